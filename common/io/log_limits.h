#pragma once
// What numbers of a log or a trajectory may be at most: beyond it a file is broken, or not what it is taken
// for.

namespace parloc {

inline constexpr double kMostCoordinate_m = 1e8;
inline constexpr double kMostHeading_rad = 1e6;
inline constexpr double kMostStamp_s = 1e12;  // microseconds stay exact in a double

}  // namespace parloc
