// Families of drives: named parts of the space of what robots meet.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace parloc {

/// In each, everything that is not its own trouble is drawn from the whole of its range. The numbers are
/// fixed: a drive is drawn from its family's.
enum class Family : std::uint32_t {
  plain = 0,            ///< No trouble but what the ranges of the sensors and of the drive bring.
  slow_scans = 1,       ///< 1 to 2 Hz.
  short_range = 2,      ///< 3.5 to 5 m.
  narrow_view = 3,      ///< 70 to 120 degrees.
  missing_returns = 4,  ///< 30 to 70 % of the beams lost.
  clutter = 5,          ///< 10 to 30 % of the hits on things that are not on the map.
  furniture_moved = 6,  ///< 5 to 20 % of the map's occupied cells changed.
  doors = 7,            ///< 20 to 60 % of the openings closed, and as many new ones.
  scale = 8,            ///< The map 1 % too large or too small.
  slips = 9,  ///< Wheels slip, or the robot is pushed: 5 to 40 degrees, 0.1 to 0.8 m, 1 to 6 a minute.
  late_odometry = 10,  ///< 0 to 200 ms late or early.
  long_steps = 11,     ///< 1 to 2.5 m from scan to scan.
  fast = 12,           ///< 2.5 to 7 m/s.
  corridor = 13,       ///< 70 m without features, its ends out of sight.
  standing = 14,       ///< Minutes, while the gyro drifts.
  kidnapped = 15,      ///< Half-way somewhere else.
  wrong_map = 16,      ///< The map is another place's.
  unknown_start = 17,  ///< Nobody says where the robot is.
};

/// In the order of their numbers.
const std::vector<Family>& all_families();
const char* name_of(Family family);
const char* meaning_of(Family family);  ///< For people, half a sentence.
/// Throws Error{usage} naming the nearest one.
Family family_named(std::string_view name);

}  // namespace parloc
