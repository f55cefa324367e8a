// MCAP files (mcap.dev, version 0), as ROS 2 and Foxglove write them.
#pragma once

#include <memory>

#include "common/bag/bag.h"
#include "common/bag/bytes/byte_stream.h"

namespace parloc {

/// With or without chunks, index, summary, end. Compressions none, zstd and lz4. Throws Error{input} if not
/// even the first record is whole.
std::unique_ptr<BagReader> open_mcap_bag(std::unique_ptr<BagFile> file);

}  // namespace parloc
