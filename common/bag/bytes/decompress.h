// Compressed bytes as a stream: memory is bounded whatever they unpack to.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/bag/bytes/byte_stream.h"

namespace parloc {

enum class Compression { none, zstd, lz4, bz2 };

/// By the name that MCAP and ROS 1 bags use ("", "none", "zstd", "lz4", "bz2"). Throws Damage naming another.
Compression compression_named(std::string_view name);

/// Unpacks what `packed` gives. reading throws Damage for data that are damaged, cut off, or want a window
/// beyond 64 MiB.
std::unique_ptr<ByteStream> decompressed(Compression compression, std::unique_ptr<ByteStream> packed);

/// Whether the bytes begin a zstd frame.
bool is_zstd(std::string_view bytes);

/// Unpacks one zstd frame (a single message) into `to`. Throws Damage, also for what unpacks to more than
/// `longest` bytes.
void unpack_zstd(std::string_view packed, std::size_t longest, std::string& to);

}  // namespace parloc
