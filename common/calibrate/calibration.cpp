#include "common/calibrate/calibration.h"

#include <algorithm>
#include <cmath>

namespace parloc {
namespace {

/// A robot with differential wheels goes along its heading; more than this share to the side is another's.
constexpr double kSideways = 0.2;
constexpr int kPasses = 2;

/// LiDARs see the same odometry, so that their answers err together: their mean is taken to be no surer than
/// they are.
Estimate1 mean_of(const std::vector<LidarCalibration>& lidars, std::size_t unknown) {
  Estimate1 mean;
  double weights = 0.0;
  for (const LidarCalibration& lidar : lidars) {
    const Estimate1& one = lidar.fit.unknown[unknown];
    if (!one.determined) continue;
    const double weight = 1.0 / (one.sigma * one.sigma);
    mean.value += weight * one.value, mean.sigma += weight * one.sigma, weights += weight;
    mean.determined = true;
  }
  if (!mean.determined) return lidars.empty() ? Estimate1{} : lidars.front().fit.unknown[unknown];
  return {mean.value / weights, mean.sigma / weights, true};
}

}  // namespace

LogCalibration calibrate(ScanMotions& motions, bool omni,
                         const std::function<bool(double fraction)>& keep_going) {
  LogCalibration found;
  OdometryPath path(motions.odometry());
  found.omni = omni || path.sideways_m() > kSideways * (path.ahead_m() + path.sideways_m());
  found.driven_m = path.ahead_m() + path.sideways_m(), found.turned_rad = path.turned_rad();
  const double parts = static_cast<double>(motions.lidars().size() * kPasses);
  double done = 0.0;
  for (LidarMotions& lidar : motions.lidars()) {
    MountFit fit = fit_mount(lidar, path, lidar.stated, found.omni);
    for (int pass = 0; pass < kPasses; ++pass, done += 1.0) {
      path.set_scales(fit.scales());
      const auto told = [&](double part) { return !keep_going || keep_going((done + part) / parts); };
      if (!motions.match_again(lidar, path, {fit.mount(), fit.delay_s()}, told)) break;
      fit = fit_mount(lidar, path, lidar.stated, found.omni);
    }
    found.lidars.push_back({lidar.name, lidar.stated, fit, lidar.scans, lidar.keys.size()});
  }
  for (std::size_t k = 0; k < kUnknowns; ++k) found.odometry[k] = mean_of(found.lidars, k);
  return found;
}

}  // namespace parloc
