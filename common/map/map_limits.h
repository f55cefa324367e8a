// How large a map may be.
#pragma once

#include <cstdint>

namespace parloc {

/// Longest side of a map in cells. Keeps squared cell distances within 31 bits and cell coordinates exact in
/// float32.
inline constexpr std::int32_t kMaxMapSide = 32767;

/// The finest and the coarsest cells [m].
inline constexpr double kFinestResolution_m = 1e-4, kCoarsestResolution_m = 1e3;

}  // namespace parloc
