// A drive as it is drawn from a family: numbers only, before anything is simulated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/eval/families/family.h"
#include "common/eval/families/places.h"
#include "common/simulator/corrupt_odometry.h"
#include "common/simulator/scenario.h"

namespace parloc {

inline constexpr std::size_t kCorridor = kPlaces.size();  ///< As a place: made to measure.

struct DrawnDrive {
  Family family = Family::plain;
  std::uint64_t seed = 1;
  std::size_t place = 0;         ///< Index into kPlaces, or kCorridor.
  std::size_t localized_on = 0;  ///< The place whose map the localizer has.
  Scenario robot;                ///< Its LiDAR, odometry, rates and seed; no map, path or clutter.
  double duration_s = 0.0;       ///< Until the last scan; both halves of a kidnapping together.
  double speed_mps = 0.0, turn_rate_rad_s = 0.0;
  double start_sigma_m = 0.0, start_sigma_rad = 0.0;  ///< As it is said.
  Pose start_error;                                   ///< What is said, seen from the true pose.
  double clutter_share = 0.0;                         ///< Wanted, of the hits.
  double people_part = 0.0;                           ///< Of the clutter; the rest is boxes.
  double furniture_share = 0.0, doors_share = 0.0;    ///< move_furniture, change_doors.
  double map_scale = 1.0;                             ///< How much too large the map is.
  double stand_s = 0.0;                               ///< Before it drives.
  double corridor_width_m = 0.0, corridor_start_m = 0.0;
  OdometryCorruption corruption;

  double view_rad() const;  ///< Of its LiDAR, a whole turn for one that sees all around.
};

inline constexpr double kCorridorLength_m = 70.0;
inline constexpr std::size_t kFewestScans = 40, kMostScans = 1200;
inline constexpr double kMostRanges = 400'000.0;  ///< Of a drive: scans times beams.

/// Draws every number from its range (docs/evaluate.md), each from a Philox word of its own: equal families
/// and seeds are equal drives on every machine.
DrawnDrive draw_drive(Family family, std::uint64_t seed);

/// Name with unit, and value, of all that was drawn and means something in this family.
std::vector<std::pair<std::string, double>> parameters_of(const DrawnDrive& drive);
std::string place_name(std::size_t place);

}  // namespace parloc
