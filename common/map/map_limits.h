// How large a map may be.
#pragma once

#include <cstdint>

namespace parloc {

/// Longest side of a map in cells. Keeps squared cell distances within 31 bits and cell coordinates exact in
/// float32.
inline constexpr std::int32_t kMaxMapSide = 32767;

}  // namespace parloc
