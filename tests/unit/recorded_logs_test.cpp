// Recorded logs are read whole: the public ones (PARLOC_DATA), and those that ship, which lie on their maps.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ostream>

#include "common/io/trajectory.h"
#include "common/map/map_reader.h"
#include "common/model/continuous_odometry.h"
#include "tests/unit/expect.h"
#include "tests/unit/real_data.h"
#include "tests/unit/whole_log.h"

namespace parloc {
namespace {

using test::Read;
using test::read_file;

std::size_t scans_of(const Read& read) {
  return static_cast<std::size_t>(
      std::count_if(read.records.begin(), read.records.end(),
                    [](const LogRecord& r) { return r.kind == RecordKind::scan; }));
}

/// Every line is read.
void expect_counts(const Read& read, std::size_t scans, std::size_t odometry, std::size_t backward_stamps) {
  EXPECT_EQ(scans_of(read), scans);
  EXPECT_EQ(read.records.size() - scans_of(read), odometry);
  EXPECT_EQ(read.warnings.backward_stamps, backward_stamps);
  EXPECT_EQ(read.warnings.broken_lines, 0u) << read.warnings.messages.front();
}

TEST(RealLog, Intel) {
  const std::string path = test::real_data("intel/scans.log");
  PARLOC_NEEDS_FILE(path);
  const Read read = read_file(path);
  expect_counts(read, 13631, 26915, 631);
  EXPECT_EQ(read.warnings.beam_count_changes, 0u);
  EXPECT_EQ(read.warnings.unknown_messages, 0u);
  for (const LogRecord& r : read.records) {
    if (r.kind == RecordKind::scan) {
      ASSERT_EQ(r.scan.ranges_m.size(), 180u);
    }
  }
}

/// Intel's logger wrote scans in bursts, with stamps hundredths of a second apart or stepping back.
TEST(RealLog, NoMotionOfARobotIsCalledAJump) {
  const MotionConfig limits;
  std::size_t read = 0;
  for (const char* name : {"intel", "aces", "tb3_house", "places/fhw"}) {
    const std::string path = test::real_data(std::string(name) + "/scans.log");
    if (!test::exists(path)) continue;
    ContinuousOdometry continuous(limits);
    for (const LogRecord& r : read_file(path).records)
      if (r.kind == RecordKind::scan) continuous.take(r.stamp_s, r.odometry);
    EXPECT_EQ(continuous.jumps(), 0u) << name;
    ++read;
  }
  if (read == 0) PARLOC_NEEDS_FILE(test::real_data("intel/scans.log"));
}

TEST(RealLog, IntelIsReadInHalfASecond) {
  const std::string path = test::real_data("intel/scans.log");
  PARLOC_NEEDS_FILE(path);
  const auto reader = open_carmen_log(path);
  LogRecord record;
  const auto start = std::chrono::steady_clock::now();
  while (reader->next(record)) {
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  RecordProperty("wall_ms", static_cast<int>(1e3 * wall_s));
  std::printf("16 MB in %.3f s\n", wall_s);
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(wall_s, 0.5);
#endif
}

TEST(RealLog, Aces) {
  const std::string path = test::real_data("aces/scans.log");
  PARLOC_NEEDS_FILE(path);
  expect_counts(read_file(path), 7374, 7375, 0);
}

TEST(RealLog, Tb3House) {
  const std::string path = test::real_data("tb3_house/scans.log");
  PARLOC_NEEDS_FILE(path);
  const Read read = read_file(path);
  ASSERT_EQ(scans_of(read), 574u);
  EXPECT_EQ(read.warnings.broken_lines, 0u) << read.warnings.messages.front();
  const Scan& scan = read.records[0].scan;
  EXPECT_EQ(scan.ranges_m.size(), 360u);
  EXPECT_NEAR(scan.angle_step_rad, 2.0 * M_PI / 359.0, 1e-9);
  EXPECT_EQ(scan.range_max_m, 3.5);
  // The line's poses have 6 decimals.
  expect_near(scan.T_base_sensor, {-0.032, 0.0, 0.0}, 2e-6, 2e-6);
}

// ---- the logs that ship -------------------------------------------------------------------------

struct Shipped {
  const char* name;
  std::size_t scans;
  double least_share;  ///< Of points within 15 m that lie on a wall, give or take a cell.
};

// The name that the list of tests shows.
void PrintTo(const Shipped& shipped, std::ostream* out) {
  *out << shipped.name;
}

class ShippedLog : public ::testing::TestWithParam<Shipped> {};

TEST_P(ShippedLog, HasAReferenceRowPerScan) {
  const std::string stem = std::string("maps/logs/") + GetParam().name;
  const Read read = read_file(stem + ".log.gz");
  const Trajectory reference = read_tum(stem + ".tum");
  ASSERT_EQ(read.records.size(), GetParam().scans);
  ASSERT_EQ(reference.size(), GetParam().scans);
  EXPECT_EQ(read.warnings.broken_lines, 0u);
  EXPECT_EQ(read.warnings.backward_stamps, 0u);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Scan& scan = read.records[i].scan;
    EXPECT_EQ(reference[i].stamp_s, scan.stamp_s);
    ASSERT_EQ(scan.ranges_m.size(), 361u);
    EXPECT_NEAR(scan.angle_min_rad, -M_PI / 2, 1e-8);
    EXPECT_NEAR(scan.angle_step_rad, M_PI / 360, 1e-8);
    EXPECT_NEAR(scan.T_base_sensor.x_m, 0.78, 2e-6);
    EXPECT_EQ(scan.range_max_m, 80.0);
  }
}

// Share of the points on a wall, corridor and faculty: 0.973 and 0.959. Mirrored beams would make it 0.15 and
// 0.04, a sensor turned by a degree 0.93 and 0.73, a map shifted by a cell 0.94 and 0.93; one shifted by half
// a cell is not seen.
TEST_P(ShippedLog, ScansLieOnTheWallsOfTheMap) {
  const std::string name = GetParam().name;
  const GridMap map = read_map("maps/" + name + ".yaml");
  const Read read = read_file("maps/logs/" + name + ".log.gz");
  const Trajectory reference = read_tum("maps/logs/" + name + ".tum");
  std::size_t near_wall = 0, points = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Scan& scan = read.records[i].scan;
    const Pose sensor = compose(reference[i].pose, scan.T_base_sensor);
    for (std::size_t k = 0; k < scan.ranges_m.size(); ++k) {
      const double r = scan.ranges_m[k];
      if (r > 15.0) continue;
      const double a = sensor.theta_rad + scan.angle_min_rad + static_cast<double>(k) * scan.angle_step_rad;
      const double x = sensor.x_m + r * std::cos(a), y = sensor.y_m + r * std::sin(a);
      ++points;
      bool wall = false;
      for (const double dx : {-0.05, 0.0, 0.05}) {
        for (const double dy : {-0.05, 0.0, 0.05})
          wall = wall || map.at_point(x + dx, y + dy) == Cell::occupied;
      }
      near_wall += wall ? 1 : 0;
    }
  }
  const double share = static_cast<double>(near_wall) / static_cast<double>(points);
  std::printf("%s: %.3f of %zu points within one cell of a wall\n", name.c_str(), share, points);
  EXPECT_GT(share, GetParam().least_share);
}

INSTANTIATE_TEST_SUITE_P(Maps, ShippedLog,
                         ::testing::Values(Shipped{"malaga_corridor", 37, 0.96},
                                           Shipped{"malaga_faculty", 225, 0.95}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace parloc
