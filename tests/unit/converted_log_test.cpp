// A log written in another format and read again has the same records.
#include "tools/log/converted_log.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/inputs/open_log.h"
#include "common/math/portable64.h"
#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"

namespace parloc::test {
namespace {

using tools::ConvertedLog;

std::vector<LogRecord> records_of(LogReader& log) {
  std::vector<LogRecord> records;
  for (LogRecord record; log.next(record);) records.push_back(record);
  return records;
}

struct Written {
  std::string bytes;
  std::vector<std::string> losses;
};

Written written(const std::vector<LogRecord>& records, bool mcap) {
  Written result;
  const auto sink = [&](std::string_view part) { result.bytes += part; };
  const auto out = mcap ? tools::convert_to_mcap(sink) : tools::convert_to_carmen(sink);
  for (const LogRecord& record : records) out->write(record);
  out->finish();
  result.losses = out->losses();
  return result;
}

std::vector<LogRecord> read_again(const Written& log, const LogChoice& choice = {}) {
  const TempFile file("log", log.bytes);
  return records_of(*open_log(file.path(), choice));
}

/// Numbers that single precision holds, so that nothing is rounded.
Scan scan_of(const std::string& sensor, double stamp_s) {
  Scan scan;
  scan.stamp_s = stamp_s;
  scan.sensor = sensor;
  scan.T_base_sensor = {0.25, -0.1, 0.7};
  scan.angle_min_rad = -1.5;
  scan.angle_step_rad = 0.25;
  scan.range_min_m = 0.125;
  scan.range_max_m = 30.0;
  scan.ranges_m = {1.5f, 2.01f, std::numeric_limits<float>::infinity(), 0.0f, 81.83f};
  return scan;
}

/// As text with 6 decimals is read.
double rounded(double stamp_s) {
  return std::round(stamp_s * 1e6) / 1e6;
}

/// Odometry, scan, odometry, scan, ...
std::vector<LogRecord> drive(const std::vector<Scan>& scans) {
  std::vector<LogRecord> records;
  for (const Scan& scan : scans) {
    const double s = rounded(scan.stamp_s);
    const double way_m = 0.1 * std::fmod(s, 100.0);
    records.push_back({RecordKind::odometry, rounded(s - 0.01), {way_m, 0.2, wrap64(way_m)}, {}, 0});
    records.push_back({RecordKind::scan, s, {way_m + 0.001, 0.2, wrap64(way_m + 0.001)}, scan, 0});
    records.back().scan.stamp_s = s;
  }
  // The last scan is between two readings, as those before it are.
  records.push_back({RecordKind::odometry, scans.back().stamp_s + 0.05, {9.0, 9.0, 1.0}, {}, 0});
  return records;
}

void expect_same(const LogRecord& a, const LogRecord& b) {
  ASSERT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.stamp_s, b.stamp_s);
  EXPECT_EQ(a.odometry.x_m, b.odometry.x_m);
  EXPECT_EQ(a.odometry.y_m, b.odometry.y_m);
  EXPECT_NEAR(a.odometry.theta_rad, b.odometry.theta_rad, 5e-16);
  if (a.kind == RecordKind::odometry) return;
  EXPECT_EQ(a.scan.stamp_s, b.scan.stamp_s);
  EXPECT_EQ(a.scan.sensor, b.scan.sensor);
  EXPECT_EQ(a.scan.angle_min_rad, b.scan.angle_min_rad);
  EXPECT_EQ(a.scan.angle_step_rad, b.scan.angle_step_rad);
  EXPECT_EQ(a.scan.upside_down, b.scan.upside_down);
  EXPECT_EQ(a.scan.range_max_m, b.scan.range_max_m);
  EXPECT_EQ(a.scan.ranges_m, b.scan.ranges_m);
  EXPECT_NEAR(a.scan.T_base_sensor.x_m, b.scan.T_base_sensor.x_m, 1e-14);
  EXPECT_NEAR(a.scan.T_base_sensor.y_m, b.scan.T_base_sensor.y_m, 1e-14);
  EXPECT_NEAR(turn_rad(a.scan.T_base_sensor, b.scan.T_base_sensor), 0.0, 1e-14);
}

void expect_same(const std::vector<LogRecord>& a, const std::vector<LogRecord>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    SCOPED_TRACE(k);
    expect_same(a[k], b[k]);
  }
}

TEST(ConvertedLog, McapHasTheSameRecords) {
  for (const double start_s : {0.5, 1.7e9}) {
    std::vector<Scan> scans;
    for (int k = 0; k < 30; ++k) scans.push_back(scan_of("front", start_s + 0.1 * k));
    const std::vector<LogRecord> records = drive(scans);
    const Written mcap = written(records, true);
    EXPECT_TRUE(mcap.losses.empty());
    const std::vector<LogRecord> read = read_again(mcap);
    // The newest reading may be of use for a scan that never came: a reader keeps it.
    expect_same(std::vector<LogRecord>(read.begin(), read.begin() + 60),
                {records.begin(), records.end() - 1});
    EXPECT_EQ(read.front().scan.range_min_m, records.front().scan.range_min_m);
  }
}

TEST(ConvertedLog, CarmenHasTheSameRecords) {
  std::vector<Scan> scans;
  for (int k = 0; k < 30; ++k) {
    scans.push_back(scan_of("robotlaser1", 1.7e9 + 0.1 * k));
    scans.back().angle_min_rad = static_cast<float>(-0.5 * kPi);
    scans.back().angle_step_rad = static_cast<float>(kPi / 360.0);
  }
  const std::vector<LogRecord> records = drive(scans);
  const Written carmen = written(records, false);
  expect_same(read_again(carmen), records);
  ASSERT_EQ(carmen.losses.size(), 1u);  // the minimum range
  expect_same(read_again(written(read_again(carmen), true)), read_again(written(records, true)));
}

TEST(ConvertedLog, KeepsSeveralLidarsByName) {
  std::vector<Scan> scans;
  for (int k = 0; k < 20; ++k) {
    scans.push_back(scan_of(k % 2 == 0 ? "front" : "rear", 100.0 + 0.1 * k));
    scans.back().T_base_sensor.theta_rad = k % 2 == 0 ? 0.0 : -kPi;
  }
  const std::vector<LogRecord> records = drive(scans);
  LogChoice both;
  both.scan_topic = "/front,/rear";
  const std::vector<LogRecord> read = read_again(written(records, true), both);
  expect_same(std::vector<LogRecord>(read.begin(), read.begin() + 40), {records.begin(), records.end() - 1});
  const Written carmen = written(records, false);
  const std::vector<LogRecord> lines = read_again(carmen);
  EXPECT_EQ(lines[1].scan.sensor, "robotlaser1");
  EXPECT_EQ(lines[3].scan.sensor, "robotlaser2");
  expect_parts(fmt::format("{}", carmen.losses.back()), {"rear is robotlaser2"});
}

TEST(ConvertedLog, KeepsLidarsThatHangUpsideDown) {
  Scan scan = scan_of("front", 10.0);
  scan.upside_down = true;
  Scan clockwise = scan_of("front", 10.0);
  clockwise.angle_min_rad = 1.5;
  clockwise.angle_step_rad = -0.25;
  for (const Scan& upside_down : {scan, clockwise}) {
    for (const bool mcap : {true, false}) {
      const std::vector<LogRecord> read = read_again(written(drive({upside_down}), mcap));
      ASSERT_GE(read.size(), 2u);
      const Scan& found = read[1].scan;
      // No CARMEN line can say it, but one may count its angles clockwise, which is the same.
      EXPECT_EQ(found.upside_down, mcap);
      const double sign = found.upside_down ? -1.0 : 1.0;
      EXPECT_EQ(sign * found.angle_min_rad, 1.5);
      EXPECT_EQ(sign * found.angle_step_rad, -0.25);
      EXPECT_NEAR(found.T_base_sensor.theta_rad, 0.7, 1e-14);
    }
  }
}

TEST(ConvertedLog, KeepsScanTimesAndLimitsThatAreNotKnown) {
  Scan scan = scan_of("front", 10.0);
  scan.scan_time_s = 0.0625;
  scan.range_min_m = scan.range_max_m = 0.0;
  const Scan found = read_again(written(drive({scan}), true))[1].scan;
  EXPECT_EQ(found.scan_time_s, 0.0625);
  EXPECT_EQ(found.range_min_m, 0.0);
  EXPECT_EQ(found.range_max_m, 0.0);
  const Written carmen = written(drive({scan}), false);
  expect_parts(carmen.losses.front(), {"how long 1 scans take"});
}

TEST(ConvertedLog, SaysOfALidarThatMoves) {
  std::vector<Scan> scans;
  for (int k = 0; k < 20; ++k) {
    scans.push_back(scan_of("front", 100.0 + 0.1 * k));
    scans.back().T_base_sensor.theta_rad = 0.05 * k;
  }
  const Written mcap = written(drive(scans), true);
  ASSERT_EQ(mcap.losses.size(), 1u);
  expect_parts(mcap.losses.front(), {"front: its place on the robot changes"});
  const std::vector<LogRecord> read = read_again(mcap);
  for (int k = 0; k < 20; ++k)
    EXPECT_NEAR(read[static_cast<std::size_t>(2 * k + 1)].scan.T_base_sensor.theta_rad, 0.05 * k, 1e-14) << k;
}

TEST(ConvertedLog, CountsOdometryThatSharesAStamp) {
  std::vector<LogRecord> records = drive({scan_of("front", 10.0), scan_of("front", 10.1)});
  records[0].stamp_s = 10.0;  // a reading and a scan of one time that do not agree
  const Written mcap = written(records, true);
  ASSERT_EQ(mcap.losses.size(), 1u);
  expect_parts(mcap.losses.front(), {"1 odometry readings have the stamp of a scan"});
  EXPECT_EQ(read_again(mcap)[0].odometry.x_m, records[1].odometry.x_m);
  records = drive({scan_of("front", 10.0), scan_of("front", 10.0)});
  records.erase(records.begin() + 2);
  records[2].odometry.x_m = 5.0;
  expect_parts(written(records, true).losses.front(), {"1 scans have the stamp of the scan before"});
}

TEST(ConvertedLog, RefusesUnevenBeamsAndTooManyLidars) {
  for (const bool mcap : {true, false}) {
    Scan scan = scan_of("front", 10.0);
    scan.bearings_rad = {0.0, 0.1, 0.3, 0.4, 0.5};
    EXPECT_THROW(written(drive({scan}), mcap), Error);
    scan.bearings_rad.clear();
    scan.beam_times_s = {0.0, 0.1, 0.3, 0.4, 0.5};
    EXPECT_THROW(written(drive({scan}), mcap), Error);
  }
  std::vector<Scan> ten;
  for (int k = 0; k < 10; ++k) ten.push_back(scan_of(fmt::format("lidar{}", k), 10.0 + k));
  EXPECT_THROW(written(drive(ten), false), Error);
  EXPECT_NO_THROW(written(drive(ten), true));
  EXPECT_THROW(written(drive({scan_of("front", 1e11)}), true), Error);
}

}  // namespace
}  // namespace parloc::test
