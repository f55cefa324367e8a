#pragma once
// Degrees, as files and people write angles, and radians, as everything is computed.

#include "common/math/portable64.h"

namespace parloc {

inline constexpr double kRadPerDeg = kPi / 180.0;
inline constexpr double kDegPerRad = 180.0 / kPi;

}  // namespace parloc
