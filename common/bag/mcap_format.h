// What readers and writers of MCAP have in common (mcap.dev, version 0).
#pragma once

#include <cstdint>
#include <string_view>

namespace parloc::mcap {

/// A file begins and ends with it.
inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);

/// What a record is: its first byte. Its length follows, in eight.
enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

}  // namespace parloc::mcap
