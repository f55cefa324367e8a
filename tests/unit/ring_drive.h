// A round corridor, and a drive along it: what comes around again. The same bits on every machine, for pinned
// digests.
#pragma once

#include <random>

#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/math/portable64.h"
#include "common/simulator/simulator.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/simulated.h"

namespace parloc::test {

/// 2 m wide, of cells of 10 cm. Posts stand out from both walls where is_post says so, of the distance along
/// the middle of the corridor in cells.
class Ring {
 public:
  Ring(double radius_m, const std::function<bool(int along)>& is_post)
      : radius_m_(radius_m), middle_m_(radius_m + 2.0) {
    const int size = static_cast<int>(std::lround(2.0 * middle_m_ / 0.1));
    std::vector<std::string> rows(static_cast<std::size_t>(size),
                                  std::string(static_cast<std::size_t>(size), '.'));
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const double x_m = (i + 0.5) * 0.1 - middle_m_, y_m = (j + 0.5) * 0.1 - middle_m_;
        const double to_wall_m = 1.0 - std::fabs(std::sqrt(x_m * x_m + y_m * y_m) - radius_m_);
        const int along = static_cast<int>((portable_atan2_64(y_m, x_m) + kPi) * radius_m_ / 0.1);
        const double deep_m = is_post(along) ? 0.35 : 0.0;
        if (to_wall_m < deep_m && to_wall_m > -0.2)
          rows[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] = '#';
      }
    map_ = grid_from_text(rows, 0.1);
  }
  const GridMap& map() const { return map_; }
  /// On the middle of the corridor, counter-clockwise.
  Pose at(double along_m) const {
    const double angle = along_m / radius_m_;
    const SinCos64 r = portable_sincos64(angle);
    return {middle_m_ + radius_m_ * r.cos, middle_m_ + radius_m_ * r.sin, wrap64(angle + kPi / 2)};
  }

 private:
  double radius_m_, middle_m_;
  GridMap map_;
};

struct RingDrive {
  static constexpr double kStep_m = 0.3;  ///< Between scans.
  std::vector<Pose> odometry;
  std::vector<Scan> scans;
  Trajectory truth;  ///< From the first scan.
};

/// Scans of 90 beams all around. `step_of(k, true step)` is what the odometry has of step k, `range_of` what
/// the LiDAR has of a range below 7.9 m.
inline RingDrive drive_along(const Ring& ring, double along_m, const std::function<Pose(int, Pose)>& step_of,
                             const std::function<double(double)>& range_of) {
  RingDrive out;
  Pose odometry;
  for (int k = 0; RingDrive::kStep_m * k < along_m; ++k) {
    const Pose pose = ring.at(RingDrive::kStep_m * k);
    if (k > 0)
      odometry = compose(odometry, step_of(k, relative(pose, ring.at(RingDrive::kStep_m * (k - 1)))));
    Scan scan{
        .stamp_s = 10.0 + 0.3 * k, .angle_min_rad = -kPi, .angle_step_rad = kPi / 45, .range_max_m = 8.0};
    for (int i = 0; i < 90; ++i) {
      const double angle_rad = pose.theta_rad + scan.angle_min_rad + i * kPi / 45;
      const double range_m = cast_simulated_ray(ring.map(), pose.x_m, pose.y_m, angle_rad, 8.0).range_m;
      scan.ranges_m.push_back(static_cast<float>(range_m < 7.9 ? range_of(range_m) : range_m));
    }
    out.odometry.push_back(odometry);
    out.scans.push_back(scan);
    out.truth.push_back({scan.stamp_s, relative(pose, ring.at(0.0))});
  }
  return out;
}

/// With noise: ranges are off by 3 cm, steps of the odometry by a hundredth and 0.2 degrees.
inline RingDrive noisy_drive_along(const Ring& ring, double along_m) {
  std::mt19937 random(7);
  const auto noise = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  const auto step_of = [&](int, Pose step) {
    step.x_m *= 0.99, step.theta_rad += 0.0035 * noise();
    return step;
  };
  return drive_along(ring, along_m, step_of, [&](double range_m) { return range_m + 0.03 * noise(); });
}

inline void run(GridSlam& slam, const RingDrive& drive, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) slam.step(drive.odometry[k], drive.scans[k]);
}
inline std::unique_ptr<GridSlam> mapped(const GridSlamConfig& config, const RingDrive& drive) {
  auto slam = std::make_unique<GridSlam>(config);
  run(*slam, drive, 0, drive.scans.size());
  return slam;
}

}  // namespace parloc::test
