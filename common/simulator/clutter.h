// Things in a simulated world that are on no map: boxes along the way, and people who walk with the robot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"

namespace parloc {

/// The clutter of one drive. Where it stands is drawn once from the seed: equal scenarios and seeds give
/// equal clutter on every machine.
class ClutterField {
 public:
  /// Boxes stand where the map is free, clear of the path by `SimulatedClutter::clearance_m`; one for which
  /// no such place is found is left out.
  ClutterField(const Scenario& scenario, const GridMap& map);

  /// Distance along a ray to the nearest thing at this time, at most `range_max_m`. The robot is at `robot`.
  double range(const Pose& robot, double time_s, double x_m, double y_m, double angle_rad,
               double range_max_m) const;

  bool empty() const { return boxes_.empty() && people_.empty(); }
  std::size_t boxes() const { return boxes_.size(); }

 private:
  struct Box {
    Pose pose;
    double half_length_m, half_width_m;
  };
  /// Someone who keeps near the robot: a circle at a bearing and distance that change slowly.
  struct Person {
    double bearing_rad, turn_rad_s;
    double distance_m, sway_m, sway_rad_s, phase_rad;
  };

  std::vector<Box> boxes_;
  std::vector<Person> people_;
  double person_radius_m_;
};

}  // namespace parloc
