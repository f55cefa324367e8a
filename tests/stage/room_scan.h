// A scan for tests that compare backends.
#pragma once

#include "common/simulator/simulator.h"

namespace parloc::test {

/// As seen from a pose of the map frame, by a sensor beside the robot's centre; every seventh beam returns
/// nothing.
inline Scan scan_with_gaps(const GridMap& map, const Pose& pose, std::size_t beams, double range_max_m) {
  Scan s{.T_base_sensor = {0.1, -0.05, 0.2},
         .angle_min_rad = -2.0,
         .angle_step_rad = 4.0 / static_cast<double>(beams),
         .range_max_m = range_max_m};
  for (std::size_t i = 0; i < beams; ++i) {
    const Pose ray = compose(compose(pose, s.T_base_sensor),
                             {0, 0, s.angle_min_rad + static_cast<double>(i) * s.angle_step_rad});
    const double range_m = cast_simulated_ray(map, ray.x_m, ray.y_m, ray.theta_rad, range_max_m).range_m;
    s.ranges_m.push_back(static_cast<float>(i % 7 == 3 ? range_max_m + 3.0 : range_m));
  }
  return s;
}

}  // namespace parloc::test
