#include "common/filter/map_frame.h"

#include <cmath>
#include <string>

#include "common/error.h"

namespace parloc {

void check_start(const GridMap& map, const Pose& pose, double sigma_x_m, double sigma_y_m,
                 double sigma_theta_rad) {
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.theta_rad))
    throw Error(ErrorKind::input, "start pose: expected finite numbers");
  const Pose in_grid = relative(pose, map.T_map_grid);
  const double cells_x = in_grid.x_m / map.resolution_m, cells_y = in_grid.y_m / map.resolution_m;
  if (!(cells_x >= 0 && cells_y >= 0 && cells_x < map.width && cells_y < map.height))
    throw Error(ErrorKind::input, "start pose (" + std::to_string(pose.x_m) + ", " +
                                      std::to_string(pose.y_m) + "): expected a point inside the map " +
                                      map.name);
  for (const double sigma : {sigma_x_m, sigma_y_m, sigma_theta_rad})
    if (!(sigma >= 0) || !std::isfinite(sigma))
      throw Error(ErrorKind::input,
                  "start pose: expected standard deviations that are finite and not negative");
}

}  // namespace parloc
