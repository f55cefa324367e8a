#include "common/io/mount_watch.h"

#include <fmt/format.h>

#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

std::string place(const Pose& pose) {
  return fmt::format("({:.2f} m, {:.2f} m, {:.1f} degrees)", pose.x_m, pose.y_m,
                     pose.theta_rad * (180.0 / kPi));
}

}  // namespace

std::optional<LogNote> MountWatch::look(const LogRecord& scan) {
  const std::string& name = scan.scan.sensor;
  const Pose& now = scan.scan.T_base_sensor;
  for (Lidar& lidar : lidars_) {
    if (lidar.name != name) continue;
    const double dx_m = now.x_m - lidar.first.x_m, dy_m = now.y_m - lidar.first.y_m;
    const double turned_rad = std::fabs(wrap64(now.theta_rad - lidar.first.theta_rad));
    const bool moved = dx_m * dx_m + dy_m * dy_m > kMoved_m * kMoved_m || turned_rad > kTurned_rad;
    if (lidar.told || !moved) return std::nullopt;
    lidar.told = true;
    return LogNote{
        LogNote::About::mount, name,
        fmt::format("{0}: its place on the robot changes from scan to scan, from {1} to {2} in line "
                    "{3}; a LiDAR that is bolted on does not move: lidars.{0}.x, y and yaw say where "
                    "it is",
                    name, place(lidar.first), place(now), scan.line)};
  }
  lidars_.push_back({name, now, false});
  return std::nullopt;
}

}  // namespace parloc
