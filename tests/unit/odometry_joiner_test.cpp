// Scans that came without odometry, and the odometry at their time.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "common/io/odometry_joiner.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

LogRecord scan_at(double stamp_s) {
  LogRecord record;
  record.kind = RecordKind::scan;
  record.stamp_s = record.scan.stamp_s = stamp_s;
  record.scan.ranges_m = {1.0f};
  return record;
}

std::vector<LogRecord> all_of(OdometryJoiner& joiner) {
  std::vector<LogRecord> records;
  for (LogRecord record; joiner.next(record);) records.push_back(record);
  return records;
}

TEST(OdometryJoiner, InterpolatesByTheShorterTurn) {
  OdometryJoiner joiner;
  joiner.add_odometry(1.0, {0.0, 2.0, 3.1}, 1);
  joiner.add_scan(scan_at(1.25));
  joiner.add_odometry(2.0, {4.0, 0.0, -3.1}, 2);
  const std::vector<LogRecord> records = all_of(joiner);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].kind, RecordKind::odometry);
  // A quarter of the way: 3.1 + (2 pi - 6.2) / 4 = 3.1207963...
  expect_near(records[1].odometry, {1.0, 1.5, 3.1207963267948966}, 1e-12, 1e-12);
  EXPECT_EQ(joiner.longest_gap_s(), 1.0);
}

TEST(OdometryJoiner, AReadingOfTheScansTimeIsTakenAsItIsAndOnce) {
  OdometryJoiner joiner;
  for (const double stamp_s : {1.0, 2.0, 3.0}) joiner.add_odometry(stamp_s, {stamp_s, 0.0, 0.1}, 0);
  joiner.add_scan(scan_at(2.0));
  joiner.finish();
  const std::vector<LogRecord> records = all_of(joiner);
  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(records[1].kind, RecordKind::scan);
  expect_equal(records[1].odometry, {2.0, 0.0, 0.1});
  EXPECT_EQ(records[2].stamp_s, 3.0);
}

TEST(OdometryJoiner, WaitsForTheOdometryAfterAScan) {
  OdometryJoiner joiner;
  LogRecord record;
  joiner.add_odometry(1.0, {}, 0);
  joiner.add_scan(scan_at(1.5));
  EXPECT_FALSE(joiner.next(record));
  joiner.add_odometry(1.6, {0.6, 0.0, 0.0}, 0);
  ASSERT_TRUE(joiner.next(record));
  EXPECT_EQ(record.kind, RecordKind::odometry);
  ASSERT_TRUE(joiner.next(record));
  EXPECT_EQ(record.kind, RecordKind::scan);
  EXPECT_NEAR(record.odometry.x_m, 0.5, 1e-12);
}

TEST(OdometryJoiner, CountsWhatLiesOutside) {
  OdometryJoiner joiner;
  for (const double stamp_s : {0.5, 1.5, 2.5}) joiner.add_scan(scan_at(stamp_s));
  joiner.add_odometry(1.0, {}, 0);
  joiner.add_odometry(2.0, {}, 0);
  joiner.finish();
  std::size_t scans = 0;
  for (const LogRecord& record : all_of(joiner)) scans += record.kind == RecordKind::scan ? 1 : 0;
  EXPECT_EQ(scans, 1u);
  EXPECT_EQ(joiner.scans_before(), 1u);
  EXPECT_EQ(joiner.scans_after(), 1u);
}

TEST(OdometryJoiner, SortsWhatCameOutOfOrder) {
  OdometryJoiner joiner;
  for (const double stamp_s : {1.0, 1.4, 1.2, 1.6}) joiner.add_odometry(stamp_s, {stamp_s, 0.0, 0.0}, 0);
  for (const double stamp_s : {1.5, 1.1, 1.3}) joiner.add_scan(scan_at(stamp_s));
  joiner.finish();
  double last_s = 0.0;
  std::size_t scans = 0;
  for (const LogRecord& record : all_of(joiner)) {
    EXPECT_GE(record.stamp_s, last_s);
    last_s = record.stamp_s;
    if (record.kind != RecordKind::scan) continue;
    ++scans;
    EXPECT_NEAR(record.odometry.x_m, record.stamp_s, 1e-12);
  }
  EXPECT_EQ(scans, 3u);
}

TEST(OdometryJoiner, GoesOnWhenTheClockWasSetBack) {
  OdometryJoiner joiner;
  for (int k = 0; k < 200; ++k) joiner.add_odometry(1000.0 + 0.1 * k, {}, 0);
  all_of(joiner);
  std::size_t scans = 0;
  for (int k = 0; k < 300; ++k) {
    joiner.add_odometry(10.0 + 0.1 * k, {0.1 * k, 0.0, 0.0}, 0);
    joiner.add_scan(scan_at(10.05 + 0.1 * k));
    for (const LogRecord& record : all_of(joiner)) scans += record.kind == RecordKind::scan ? 1 : 0;
  }
  EXPECT_GT(scans, 280u);
}

TEST(OdometryJoiner, RemembersSecondsOnly) {
  OdometryJoiner joiner;
  std::size_t out = 0;
  for (int k = 0; k < 100000; ++k) {
    joiner.add_odometry(0.01 * k, {}, 0);
    for (LogRecord record; joiner.next(record);) ++out;
  }
  joiner.finish();
  out += all_of(joiner).size();
  EXPECT_EQ(out, 100000u);
  EXPECT_LE(joiner.remembered(), 2500u);
}

TEST(OdometryJoiner, SaysWhyThereIsNone) {
  OdometryJoiner joiner;
  joiner.add_scan(scan_at(7.0));
  EXPECT_EQ(joiner.why_none(), "expected odometry, found scans alone");
  joiner.add_odometry(100.0, {}, 0);
  joiner.add_odometry(200.5, {}, 0);
  EXPECT_EQ(joiner.why_none(),
            "no scan lies between two readings of the odometry: scans from 7.000 to 7.000 s, odometry from "
            "100.000 to 200.500 s");
}

}  // namespace
}  // namespace parloc
