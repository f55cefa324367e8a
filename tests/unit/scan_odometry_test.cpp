// Odometry from scans alone, on a simulated drive whose truth is known, and on a recorded log.
#include <gtest/gtest.h>

#include "common/eval/metrics.h"
#include "common/filter/steps/step_front_end.h"
#include "common/slam/grid_slam_config.h"
#include "common/slam/scan_odometry.h"
#include "common/slam/slam_backend.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

const std::vector<LogRecord>& drive() {
  static const std::vector<LogRecord> scans = scans_of(hall_drive());
  return scans;
}
std::vector<LogRecord> part_of_drive(std::size_t begin, std::size_t end) {
  const auto at = [](std::size_t k) { return drive().begin() + static_cast<std::ptrdiff_t>(k); };
  return {at(begin), at(end)};
}

class Walker {
 public:
  Walker() : odometry(make_cpu_scan_matcher({bind_matcher_rules(SlamConfig{}), 1, 0})), front_end_(config_) {}

  void walk(const LogRecord& r) {
    const std::size_t lidar = front_end_.lidar_of(r.scan);
    const bool enough = front_end_.take(r.scan, {}, SlamConfig{}.resolution, beams_);
    path.push_back({r.stamp_s, odometry.step(r.stamp_s, beams_, lidar, enough)});
  }
  void walk(const std::vector<LogRecord>& scans) {
    for (const LogRecord& r : scans) walk(r);
  }
  const ScanOdometryCounts& counts() const { return odometry.state().counts; }

  ScanOdometry odometry;
  Trajectory path;

 private:
  GridSlamConfig config_;
  StepFrontEnd front_end_;
  BeamTable beams_;
};

double end_error_m(const Trajectory& path) {
  return distance_m(path.back().pose, truth_of_hall_drive().back().pose);
}

void expect_same_path(const Trajectory& a, const Trajectory& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) expect_equal(a[k].pose, b[k].pose);
}

// Of 17 m: 2 % of the path, what wheels that are well calibrated give.
TEST(ScanOdometry, DriftsLittle) {
  Walker w;
  w.walk(drive());
  EXPECT_EQ(w.counts().scans, drive().size());
  EXPECT_EQ(w.counts().unfit, 0u);
  EXPECT_LT(end_error_m(w.path), 0.34);
  EXPECT_LT(compare_tracks(w.path, truth_of_hall_drive()).heading_rmse_rad, 0.03);
}

TEST(ScanOdometry, TheSameBitsOnEveryInstructionSet) {
  std::vector<Trajectory> paths;
  for (const cpu::Simd set : test::instruction_sets()) {
    const test::SimdLimit limit(set);
    Walker w;
    w.walk(part_of_drive(0, 60));
    paths.push_back(w.path);
  }
  for (const Trajectory& path : paths) expect_same_path(path, paths.front());
}

// What a checkpoint needs.
TEST(ScanOdometry, GoesOnFromItsState) {
  Walker whole, first, second;
  const std::size_t half = drive().size() / 2;
  whole.walk(drive());
  first.walk(part_of_drive(0, half));
  second.odometry.restore(first.odometry.state());
  second.walk(part_of_drive(half, drive().size()));
  Trajectory both = first.path;
  both.insert(both.end(), second.path.begin(), second.path.end());
  expect_same_path(whole.path, both);
  EXPECT_EQ(whole.counts().scans, second.counts().scans);
}

// Stamps that stand still or go backwards only say nothing of the speed.
TEST(ScanOdometry, OddStampsDoNoHarm) {
  for (const double back_s : {0.0, 0.9}) {
    std::vector<LogRecord> scans = drive();
    for (std::size_t k = 5; k < scans.size(); k += 7)
      scans[k].stamp_s = scans[k].scan.stamp_s = scans[k - 1].stamp_s - back_s;
    Walker w;
    w.walk(scans);
    EXPECT_EQ(w.counts().new_maps, 0u) << back_s;
    EXPECT_LT(end_error_m(w.path), 0.34) << back_s;
  }
}

// A place that looks like nothing before: the prediction is kept, then the map begun anew.
TEST(ScanOdometry, SaysWhereNothingFits) {
  Walker w;
  w.walk(part_of_drive(0, 30));
  const Pose before = w.path.back().pose;
  for (int k = 0; k < 25; ++k) {
    LogRecord r = drive()[30];
    r.stamp_s += 0.1 * k;
    for (std::size_t i = 0; i < r.scan.ranges_m.size(); ++i)
      r.scan.ranges_m[i] = 0.4f + 0.3f * static_cast<float>(i % 3);  // beams of a cage
    w.walk(r);
  }
  EXPECT_EQ(w.counts().unfit, 10u);
  EXPECT_EQ(w.counts().new_maps, 1u);
  EXPECT_LT(distance_m(w.path.back().pose, before), 2.0);
}

TEST(ScanOdometry, TooFewBeamsKeepThePrediction) {
  Walker w;
  w.walk(part_of_drive(0, 30));
  LogRecord blind = drive()[30];
  blind.scan.ranges_m.assign(blind.scan.ranges_m.size(), 0.0f);
  w.walk(blind);
  EXPECT_EQ(w.counts().unfit, 1u);
  w.walk(drive()[31]);
  EXPECT_EQ(w.counts().unfit, 1u);
}

}  // namespace
}  // namespace parloc
