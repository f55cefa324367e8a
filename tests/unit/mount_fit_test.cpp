// Where a LiDAR sits, scales and delay of the odometry are found from exact motions, and what a drive leaves
// open is said to be open.
#include "common/calibrate/mount_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/calibrate/line_scan.h"
#include "common/calibrate/mount_check.h"
#include "common/map/map_reader.h"
#include "common/model/odometry_scaler.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

using Way = std::function<Pose(double)>;

/// Turns here and there, at changing speed.
Pose winding(double t_s) {
  return {1.5 * std::sin(0.23 * t_s), 0.4 * t_s + 0.3 * std::sin(0.9 * t_s),
          1.1 * std::sin(0.5 * t_s) + 0.5 * std::sin(1.3 * t_s)};
}

/// The same heading as its way: what differential wheels do.
class Rolling {
 public:
  Rolling() {
    Pose now;
    for (int k = 0; k < 12'000; ++k) {
      poses_.push_back(now);
      const double t_s = 0.01 * k;
      now = compose(now, arc_end({0.01 * (0.5 + 0.3 * std::sin(0.7 * t_s)), 0.0,
                                  0.01 * (0.8 * std::sin(0.4 * t_s) + 0.4 * std::cos(1.1 * t_s))}));
    }
  }
  Pose operator()(double t_s) const {
    const double at = std::min(std::max(t_s / 0.01, 0.0), 11'998.0);
    const auto k = static_cast<std::size_t>(at);
    return compose(poses_[k], along_arc(relative(poses_[k + 1], poses_[k]), at - static_cast<double>(k)));
  }

 private:
  std::vector<Pose> poses_;
};

/// Readings every 20 ms whose motion, times the scales, is that of `way` so much earlier.
Trajectory odometry_of(const Way& way, const OdometryScales& scales, double delay_s) {
  Trajectory readings{{0.0, {3.0, -1.0, 0.7}}};
  Pose before = way(-delay_s);
  for (int k = 1; k < 5500; ++k) {
    const Pose now = way(0.02 * k - delay_s);
    const ArcMotion arc = arc_motion(relative(now, before));
    before = now;
    readings.push_back({0.02 * k, compose(readings.back().pose,
                                          arc_end({arc.ahead_m / scales.drive, arc.side_m / scales.side,
                                                   arc.turn_rad / scales.turn}))});
  }
  return readings;
}

/// Motions of a LiDAR there, every 0.7 s, a millimetre and a milliradian sure.
LidarMotions motions_of(const Way& way, const Mount& mount) {
  LidarMotions lidar{.name = "front", .stated = {}};
  for (int k = 0; k < 140; ++k) {
    const double from_s = 2.0 + 0.7 * k, to_s = from_s + 0.7;
    lidar.keys.push_back({from_s, {}});
    const Pose base = relative(way(to_s), way(from_s));
    const Pose step = compose(compose(inverse(mount.T_base_sensor), base), mount.T_base_sensor);
    ScanMotion motion{.from = static_cast<std::size_t>(k), .usable = true};
    motion.match.step = mount.upside_down ? mirrored(step) : step;
    for (std::size_t i = 0; i < 3; ++i) motion.match.covariance[i][i] = 1e-6;
    lidar.motions.push_back(motion);
  }
  lidar.keys.push_back({2.0 + 0.7 * 140, {}});
  return lidar;
}

MountFit fit(const Way& way, const Mount& mount, const OdometryScales& scales, double delay_s, bool omni) {
  OdometryPath path(odometry_of(way, scales, delay_s));
  return fit_mount(motions_of(way, mount), path, {}, omni);
}

TEST(MountFit, FindsEveryMountScaleAndDelay) {
  const Rolling rolling;
  const Mount mounts[] = {{{0.2, 0.0, 0.0}, false},
                          {{-0.1, 0.0, 3.14159}, false},
                          {{0.1, 0.15, 1.5708}, true},
                          {{0.0, -0.3, -2.5}, true}};
  const double delays_s[] = {0.0, 0.06, 0.2, -0.1};
  for (std::size_t k = 0; k < 4; ++k) {
    const OdometryScales scales{1.1, 1.1, 0.9, 0.0};
    const MountFit found = fit(rolling, mounts[k], scales, delays_s[k], false);
    EXPECT_TRUE(found.side_known);
    EXPECT_EQ(found.upside_down, mounts[k].upside_down);
    for (const Unknown u :
         {Unknown::x, Unknown::y, Unknown::yaw, Unknown::drive, Unknown::turn, Unknown::delay})
      EXPECT_TRUE(found[u].determined) << k << " " << static_cast<int>(u);
    EXPECT_LT(distance_m(found.mount().T_base_sensor, mounts[k].T_base_sensor), 0.001) << k;
    EXPECT_LT(turn_rad(found.mount().T_base_sensor, mounts[k].T_base_sensor), 0.001) << k;
    EXPECT_NEAR(found[Unknown::drive].value, 1.1, 0.001) << k;
    EXPECT_NEAR(found[Unknown::turn].value, 0.9, 0.001) << k;
    EXPECT_NEAR(found.delay_s(), delays_s[k], 0.001) << k;
  }
}

TEST(MountFit, FindsBothScalesOfARobotThatDrivesSideways) {
  const OdometryScales scales{1.05, 0.93, 1.08, 0.0};
  const MountFit found = fit(winding, {{0.1, -0.2, 0.5}, false}, scales, 0.05, true);
  EXPECT_NEAR(found[Unknown::drive].value, 1.05, 0.003);
  EXPECT_NEAR(found[Unknown::side].value, 0.93, 0.003);
  EXPECT_NEAR(found[Unknown::turn].value, 1.08, 0.003);
  EXPECT_TRUE(found[Unknown::side].determined);
}

TEST(MountFit, SaysWhatADriveLeavesOpen) {
  const MountFit straight = fit(
      [](double t_s) {
        return Pose{0.5 * t_s, 0.0, 0.0};
      },
      {{0.2, 0.0, 1.0}, false}, {}, 0.0, false);
  EXPECT_NEAR(straight[Unknown::yaw].value, 1.0, 0.01);
  EXPECT_TRUE(straight[Unknown::drive].determined);
  EXPECT_FALSE(straight.side_known);
  for (const Unknown u : {Unknown::x, Unknown::y, Unknown::turn, Unknown::delay})
    EXPECT_FALSE(straight[u].determined) << static_cast<int>(u);

  const MountFit spinning = fit(
      [](double t_s) {
        return Pose{1.0, 2.0, 0.7 * t_s};
      },
      {{0.2, 0.1, 1.0}, true}, {}, 0.0, false);
  EXPECT_TRUE(spinning.side_known);
  EXPECT_TRUE(spinning.upside_down);
  EXPECT_TRUE(spinning[Unknown::turn].determined);
  for (const Unknown u : {Unknown::yaw, Unknown::drive, Unknown::x, Unknown::y, Unknown::delay})
    EXPECT_FALSE(spinning[u].determined) << static_cast<int>(u);

  const MountFit still = fit([](double) { return Pose{1.0, 2.0, 0.7}; }, {}, {}, 0.0, false);
  for (const Estimate1& one : still.unknown) EXPECT_FALSE(one.determined);
}

TEST(MountFit, SlipsAndWrongMatchesHardlyCount) {
  const Rolling rolling;
  const Mount mount{{0.1, 0.15, 1.5708}, false};
  LidarMotions lidar = motions_of(rolling, mount);
  for (std::size_t k = 3; k < lidar.motions.size(); k += 10)
    lidar.motions[k].match.step = compose(lidar.motions[k].match.step, {0.5, -0.3, 0.4});
  OdometryPath path(odometry_of(rolling, {}, 0.0));
  const MountFit found = fit_mount(lidar, path, {}, false);
  EXPECT_EQ(found.unlike, 14u);
  EXPECT_LT(distance_m(found.mount().T_base_sensor, mount.T_base_sensor), 0.003);
  EXPECT_NEAR(found[Unknown::yaw].value, 1.5708, 0.003);
}

TEST(OdometryScaler, PutsScalesRightWhateverTheReadings) {
  const Rolling way;
  MotionConfig motion;
  motion.odometry_scale_drive = 1.1, motion.odometry_scale_turn = 0.9;
  const Trajectory raw = odometry_of(way, {1.1, 1.1, 0.9, 0.0}, 0.0);
  OdometryScaler all(motion), some(motion);
  Pose by_all, by_some, first;
  for (std::size_t k = 0; k < raw.size(); ++k) {
    by_all = all.take(raw[k].pose);
    if (k == 0) first = by_all;
    if (k % 3 == 0) by_some = some.take(raw[k].pose);
    if (k % 3 == 0 && k > 0) some.take(raw[k - 1].pose), by_some = some.take(raw[k].pose);
    if (k != 5400) continue;
    EXPECT_LT(distance_m(relative(by_all, first), relative(way(0.02 * 5400), way(0.0))), 1e-6);
    EXPECT_LT(distance_m(by_all, by_some), 0.01);
  }
  const MotionConfig one;
  OdometryScaler unscaled(one);
  const Pose odd{1.0 / 3.0, 1e17, 3.0};
  EXPECT_EQ(unscaled.take(odd).y_m, odd.y_m);
  EXPECT_FALSE(all.take({1e308, -1e308, 0.0}).x_m == 0.0);
  EXPECT_TRUE(is_finite(all.take({0.0, 1.0, 0.0})));
}

/// A short drive through the hall.
SimulatedLog hall_drive(const Pose& mount, bool upside_down) {
  Scenario s;
  s.path.points = {{1.8, 1.7, 0.0, 3.0}, {6.4, 1.7, 0.0, -3.0}, {8.44, 4.42, 0.0, 0.0}, {12.04, 4.42}};
  s.path.speed_mps = 0.5, s.path.turn_rate_rad_s = 0.6;
  s.scan_rate_hz = 5.0;
  s.lidar.beams = 360;
  s.lidar.angle_min_rad = -3.14159, s.lidar.angle_step_rad = 0.0174533;
  s.lidar.T_base_sensor = mount, s.lidar.upside_down = upside_down;
  return simulate(s, read_map(std::string(PARLOC_SOURCE_DIR) + "/maps/fine/hall_obstacles.yaml"));
}

TEST(LineMatch, StepsAreNeitherLongNorShort) {
  const SimulatedLog log = hall_drive({}, false);
  std::vector<LineScan> scans;
  std::vector<Pose> truth;
  const ScanConfig config;
  for (const LogRecord& record : log.records) {
    if (record.kind != RecordKind::scan) continue;
    scans.push_back(line_scan(record.scan, lidar_setup(record.scan, config)));
    truth.push_back(log.truth[truth.size()].pose);
  }
  double too_long_m = 0.0, way_m = 0.0;
  for (std::size_t k = 0; k + 4 < scans.size(); k += 4) {
    const Pose step = relative(truth[k + 4], truth[k]);
    const LineMatch match = match_lines(scans[k], scans[k + 4], {});
    if (distance_m({}, step) < 0.3) continue;
    ASSERT_TRUE(match.fits());
    EXPECT_LT(distance_m(match.step, step), 0.03);
    too_long_m += match.step.x_m - step.x_m, way_m += step.x_m;
  }
  EXPECT_GT(way_m, 8.0);
  EXPECT_LT(std::fabs(too_long_m), 0.004 * way_m);
}

TEST(MountCheck, NamesALidarThatSitsElsewhere) {
  const auto verdict = [](const SimulatedLog& log, const Pose& stated) {
    MountCheck check;
    for (LogRecord record : log.records) {
      record.scan.T_base_sensor = stated, record.scan.upside_down = false;
      check.add(record);
    }
    return check.verdict();
  };
  const SimulatedLog backwards = hall_drive({-0.1, 0.0, 3.14159}, false);
  const auto notes = verdict(backwards, {-0.1, 0.0, 0.0});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].text.find("turned by"), std::string::npos) << notes[0].text;
  EXPECT_NE(notes[0].text.find("180"), std::string::npos) << notes[0].text;
  EXPECT_TRUE(verdict(backwards, {-0.1, 0.0, 3.14159}).empty());
  const auto over = verdict(hall_drive({0.1, 0.0, 0.0}, true), {0.1, 0.0, 0.0});
  ASSERT_EQ(over.size(), 1u);
  EXPECT_NE(over[0].text.find("as if the LiDAR were upside down, other"), std::string::npos) << over[0].text;
}

}  // namespace
}  // namespace parloc
