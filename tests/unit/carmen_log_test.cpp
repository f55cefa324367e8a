// The reader of CARMEN logs: what a line means, what is wrong with it, and files that end too early.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"
#include "tests/unit/whole_log.h"

namespace parloc {
namespace {

using test::Read;
using test::read_file;
using test::read_text;
using test::TempFile;
constexpr double kDeg = M_PI / 180.0;

std::string flaser(std::size_t beams, const std::string& range = "1.50", const std::string& name = "FLASER") {
  std::string line = name + " " + std::to_string(beams);
  for (std::size_t i = 0; i < beams; ++i) line += " " + range;
  return line + " 9 9 9 1.0 2.0 0.5 100.250000 host 0.1\n";
}

std::string gzip(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// The only record of a text without a broken line; an empty one, and a failure, if there is another number.
LogRecord only_record(const std::string& text) {
  const Read read = read_text(text);
  EXPECT_EQ(read.records.size(), 1u) << text;
  EXPECT_EQ(read.warnings.broken_lines, 0u) << text;
  return read.records.size() == 1 ? read.records[0] : LogRecord{};
}

TEST(CarmenLog, OdomHasPoseAndIpcStamp) {
  const LogRecord r = only_record("ODOM 1.5 -2.5 4.0 0.1 0.2 0.0 976052857.337284 nohost 12.5\n");
  EXPECT_EQ(r.kind, RecordKind::odometry);
  EXPECT_EQ(r.stamp_s, 976052857.337284);
  expect_near(r.odometry, {1.5, -2.5, 4.0 - 2.0 * M_PI}, 0.0, 1e-15);
  EXPECT_EQ(r.line, 1u);
}

TEST(CarmenLog, FlaserTakesTheSecondPoseAsOdometry) {
  const LogRecord r = only_record("FLASER 3 1 2.5 81.83 7 8 0.9 1 2 0.5 100.25 host 0.1\n");
  EXPECT_EQ(r.kind, RecordKind::scan);
  EXPECT_EQ(r.scan.sensor, "front");
  expect_equal(r.odometry, {1.0, 2.0, 0.5});
  EXPECT_EQ(r.scan.stamp_s, 100.25);
  EXPECT_EQ(r.stamp_s, 100.25);
  EXPECT_EQ(r.scan.ranges_m, (std::vector<float>{1.0f, 2.5f, 81.83f}));
  EXPECT_EQ(r.scan.range_max_m, 0.0) << "the line does not say";
}

// {beams, step}: even counts leave the end at +90 degrees out, odd counts have it.
class HalfCircle : public ::testing::TestWithParam<std::pair<std::size_t, double>> {};
TEST_P(HalfCircle, StepFollowsTheCount) {
  const auto [beams, step_deg] = GetParam();
  const Scan scan = only_record(flaser(beams)).scan;
  EXPECT_DOUBLE_EQ(scan.angle_min_rad, -90.0 * kDeg);
  EXPECT_DOUBLE_EQ(scan.angle_step_rad, step_deg * kDeg);
}
using Count = std::pair<std::size_t, double>;
INSTANTIATE_TEST_SUITE_P(Counts, HalfCircle,
                         ::testing::Values(Count{180, 1.0}, Count{181, 1.0}, Count{360, 0.5}, Count{361, 0.5},
                                           Count{91, 2.0}, Count{2, 90.0}, Count{721, 0.25}),
                         [](const auto& test) { return std::to_string(test.param.first); });

TEST(CarmenLog, OneBeamLooksAhead) {
  EXPECT_EQ(only_record(flaser(1)).scan.angle_min_rad, 0.0);
}

TEST(CarmenLog, ParamsMountFrontAndRearLaser) {
  const Read read =
      read_text("PARAM robot_frontlaser_offset 0.25 nohost 0\nPARAM robot_rearlaser_offset -0.4 nohost 0\n" +
                flaser(2) + flaser(2, "3.0", "RLASER") + "PARAM robot_rearlaser_offset 0.5 nohost 0\n" +
                flaser(2, "3.0", "RLASER"));
  ASSERT_EQ(read.records.size(), 3u);
  const Pose& front = read.records[0].scan.T_base_sensor;
  EXPECT_EQ(front.x_m, 0.25);
  EXPECT_EQ(front.theta_rad, 0.0);
  EXPECT_EQ(read.records[1].scan.sensor, "rear");
  EXPECT_EQ(read.records[1].scan.T_base_sensor.x_m, -0.4);
  EXPECT_DOUBLE_EQ(read.records[1].scan.T_base_sensor.theta_rad, -M_PI) << "backwards, in [-pi, pi)";
  EXPECT_EQ(read.records[2].scan.T_base_sensor.x_m, -0.5)
      << "the sensor is behind, whatever the sign in the log";
  EXPECT_EQ(read.warnings.broken_lines, 0u);
}

TEST(CarmenLog, RobotlaserHasAnglesLimitsAndSensorPose) {
  // Robot at (1, 2, 90 deg), laser 0.3 m ahead of it and 0.1 m to its left, turned by 10 degrees.
  const LogRecord r = only_record(
      "ROBOTLASER1 0 -2.094395 4.188790 0.017453 5.6 0.01 0 3 1 2 3 2 40 41 0.9 2.3 1.7453293 1 2 1.5707963 "
      "0 0 0.1 0.1 1e6 50.5 host 0.2\n");
  EXPECT_EQ(r.scan.sensor, "robotlaser1");
  expect_near(r.scan.T_base_sensor, {0.3, 0.1, 10 * kDeg}, 1e-7, 1e-7);
  EXPECT_EQ(r.scan.angle_min_rad, -2.094395);
  EXPECT_EQ(r.scan.angle_step_rad, 0.017453)
      << "the field of view does not fit 3 beams: the resolution counts";
  EXPECT_EQ(r.scan.range_max_m, 5.6);
  EXPECT_EQ(r.scan.ranges_m.size(), 3u);
  EXPECT_EQ(r.stamp_s, 50.5);
}

TEST(CarmenLog, RobotlaserStepIsFinerThanItsSixDecimals) {
  const auto step_of = [](const std::string& fov, const std::string& resolution, int beams) {
    std::string line = "ROBOTLASER1 0 0 " + fov + " " + resolution + " 8 0.01 0 " + std::to_string(beams);
    for (int i = 0; i < beams; ++i) line += " 1";
    return only_record(line + " 0 0 0 0 0 0 0 0 0 0 0 0 5 h 0\n").scan.angle_step_rad;
  };
  EXPECT_DOUBLE_EQ(step_of("6.283185", "0.017502", 360), 6.283185 / 359) << "both ends counted";
  EXPECT_DOUBLE_EQ(step_of("6.283185", "0.017453", 360), 6.283185 / 360) << "one end counted";
  EXPECT_DOUBLE_EQ(step_of("3.141593", "0", 181), 3.141593 / 180) << "no resolution given";
  EXPECT_DOUBLE_EQ(step_of("3.141593", "0.02", 181), 0.02) << "they contradict: the resolution counts";
}

TEST(CarmenLog, NanAndInfAreRanges) {
  const auto r = only_record("FLASER 5 nan inf -inf NaN +0.5 0 0 0 1 2 0.5 100.25 host 0.1\n").scan.ranges_m;
  ASSERT_EQ(r.size(), 5u);
  EXPECT_TRUE(std::isnan(r[0]));
  EXPECT_EQ(r[1], std::numeric_limits<float>::infinity());
  EXPECT_EQ(r[2], -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(r[3]));
  EXPECT_EQ(r[4], 0.5f);
}

TEST(CarmenLog, BrokenLinesAreCountedAndDescribed) {
  const Read read = read_text("# a comment\n" + flaser(4) +
                              "FLASER 4 1 2 x 4 9 9 9 1 2 0.5 100.25 host 0.1\n"
                              "ODOM 1 nan 0 0 0 0 1 h 0\n" +
                              flaser(4));
  EXPECT_EQ(read.records.size(), 2u);
  EXPECT_EQ(read.warnings.broken_lines, 2u);
  const std::vector<std::string> messages{"x.log:3: expected a range, found 'x'",
                                          "x.log:4: expected finite odometry, found 'nan'"};
  EXPECT_EQ(read.warnings.messages, messages);
}

class Broken : public ::testing::TestWithParam<std::string> {};
TEST_P(Broken, LineIsSkippedAndCounted) {
  const Read read = read_text(GetParam() + "\n" + flaser(2));
  EXPECT_EQ(read.records.size(), 1u);
  EXPECT_EQ(read.warnings.broken_lines, 1u);
  ASSERT_EQ(read.warnings.messages.size(), 1u);
  EXPECT_EQ(read.warnings.messages[0].rfind("x.log:1: expected", 0), 0u) << read.warnings.messages[0];
}
INSTANTIATE_TEST_SUITE_P(
    CarmenLog, Broken,
    ::testing::Values("FLASER", "FLASER 4000000000 1 1 0 0 0 0 0 0 1 h 1", "FLASER -1 0 0 0 0 0 0 1 h 1",
                      "FLASER 0 0 0 0 0 0 0 1 h 1", "FLASER 18446744073709551616 1",
                      "FLASER 3 1 2 0 0 0 0 0 0 1 h 1", "FLASER 2 1 2 3 0 0 0 0 0 0 1 h 1",
                      "FLASER 2 1 2 0 0 0 0 0 0 inf h 1", "FLASER 2 1 2 0 0 0 0 0 1e300 1 h 1",
                      "FLASER 2 1e60 2 0 0 0 0 0 0 1 h 1", "FLASER 2 1,5 2 0 0 0 0 0 0 1 h 1", "ODOM 1 2 3",
                      "ODOM 1 2 3 0 0 0 1 h 0 extra", "PARAM robot_frontlaser_offset on",
                      "PARAM robot_rearlaser_offset nan", "%$#@ 1 2 3", "ROBOTLASER1 0 0 3.1 0 8 0 0 1",
                      "ROBOTLASER1 0 0 0 0 8 0 0 2 1 1 0 0 0 0 0 0 0 0 0 0 0 0 5 h 0",
                      "ROBOTLASER1 0 0 12 12 8 0 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 5 h 0",
                      "ROBOTLASER1 0 0 3 1 8 0 0 2 1 1 99 0 0 0 0 0 0 0 0 0 0 0 5 h 0"));

TEST(CarmenLog, AtMostTwentyMessages) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "ODOM broken\n";
  const Read read = read_text(text);
  EXPECT_EQ(read.warnings.broken_lines, 1000u);
  EXPECT_EQ(read.warnings.messages.size(), 20u);
}

TEST(CarmenLog, OtherMessagesAreCountedNotBroken) {
  const Read read = read_text(
      "SYNC tag 1 h 0\nTRUEPOS 1 2 3 0 0 0 1 h 0\n\n   \n# ODOM\nPARAM robot_length 1 h 0\nNMEA-GGA 1\n");
  EXPECT_EQ(read.warnings.unknown_messages, 3u);
  EXPECT_EQ(read.warnings.broken_lines, 0u);
}

TEST(CarmenLog, RecordsAndBrokenLinesAreCounted) {
  const std::string overlong(std::size_t{3} << 20, '7');
  const struct {
    const char* name;
    std::string text;
    std::size_t records, broken_lines;
  } cases[] = {
      {"line ends of Windows, and tabs", "ODOM\t1 2 3 0 0 0 7.5 h 0\r\n\r\nODOM 1 2 3 0 0 0 8.5 h 0\r\n", 2,
       0},
      {"a last line without an end", "ODOM 1 2 3 0 0 0 7.5 h 0", 1, 0},
      {"half a stamp is a wrong stamp", "ODOM 1 2 3 0 0 0 976052857.33", 0, 1},
      {"nothing", "", 0, 0},
      {"an overlong line", flaser(2) + overlong + "\n" + flaser(2), 2, 1},
      {"an overlong line as the last", std::string(overlong.size(), ' '), 0, 1},
      {"a scan that just fits", flaser(200000), 1, 0},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Read read = read_text(c.text);
    EXPECT_EQ(read.records.size(), c.records);
    EXPECT_EQ(read.warnings.broken_lines, c.broken_lines);
  }
  EXPECT_EQ(read_text(flaser(2) + overlong + "\n" + flaser(2)).records.at(1).line, 3u);
}

TEST(CarmenLog, BackwardStampsKeepFileOrder) {
  const auto at = [](const char* stamp) { return std::string("FLASER 1 1 0 0 0 0 0 0 ") + stamp + " h 0\n"; };
  const Read read = read_text(at("5.0") + at("4.0") + at("4.0") + at("6.0") + at("5.5"));
  ASSERT_EQ(read.records.size(), 5u);
  EXPECT_EQ(read.records[1].stamp_s, 4.0);
  EXPECT_EQ(read.warnings.backward_stamps, 2u);
}

TEST(CarmenLog, BeamCountChangesAreCountedPerSensor) {
  const Read read = read_text(flaser(4) + flaser(8, "1", "RLASER") + flaser(4) + flaser(8, "1", "RLASER") +
                              flaser(3) + flaser(3) + flaser(4));
  EXPECT_EQ(read.warnings.beam_count_changes, 2u);
}

TEST(CarmenLog, PlainAndGzipReadTheSame) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += flaser(180, "1.25") + "ODOM 1 2 3 0 0 0 7.5 h 0\n";
  const TempFile plain("plain.log", text), packed("packed.log", gzip(text));
  EXPECT_EQ(read_file(plain.path()).records.size(), 6000u);
  EXPECT_EQ(read_file(packed.path()).records.size(), 6000u);
}

/// Scans that all differ, so that they do not pack well.
std::string many_scans(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += flaser(180, std::to_string(0.001 * i));
  return text;
}

TEST(CarmenLog, ProgressGrowsToOne) {
  const std::string text = many_scans(2000);
  for (const std::string& content : {text, gzip(text)}) {
    const TempFile file("progress.log", content);
    const auto reader = open_carmen_log(file.path());
    LogRecord record;
    double last = 0.0;
    bool between = false;
    while (reader->next(record)) {
      EXPECT_GE(reader->progress(), last);
      last = reader->progress();
      between = between || (last > 0.2 && last < 0.9);
    }
    EXPECT_TRUE(between || content.size() < 200000) << "a long file is not read in one piece";
    EXPECT_EQ(reader->progress(), 1.0);
  }
}

TEST(CarmenLog, TruncatedGzipKeepsWhatWasRead) {
  const std::string packed = gzip(many_scans(2000));
  const TempFile file("cut.log.gz", packed.substr(0, packed.size() / 2));
  const Read read = read_file(file.path());
  EXPECT_GT(read.records.size(), 500u);
  EXPECT_LT(read.records.size(), 2000u);
  EXPECT_EQ(read.warnings.broken_lines, 1u);
  ASSERT_EQ(read.warnings.messages.size(), 1u);
  expect_parts(read.warnings.messages[0], {"gzip data ends too early"});
}

TEST(CarmenLog, DamagedGzipIsCounted) {
  std::string packed = gzip(many_scans(4000));
  for (std::size_t i = packed.size() - 2000; i < packed.size() - 1900; ++i)
    packed[i] = static_cast<char>(0xff);
  const TempFile file("damaged.log.gz", packed);
  const Read read = read_file(file.path());
  EXPECT_GT(read.records.size(), 0u);
  EXPECT_LT(read.records.size(), 4000u);
  EXPECT_EQ(read.warnings.broken_lines, 1u);
}

TEST(CarmenLog, FilesThatCannotBeReadThrow) {
  const TempFile stump("stump.gz", gzip("ODOM").substr(0, 10));
  for (const std::string& path : {std::string("no/such.log"), std::string("/tmp"), stump.path()}) {
    const std::string message = error_of([&] { open_carmen_log(path); });
    EXPECT_EQ(message.rfind(path + ": ", 0), 0u) << message;
  }
}

TEST(CarmenLog, LineRoundTrip) {
  LogRecord record;
  record.kind = RecordKind::scan;
  record.odometry = {12.25, -3.5, 3.0};
  record.scan.stamp_s = record.stamp_s = 1137772793.094853;
  record.scan.T_base_sensor = {0.17, -0.02, 0.3};
  record.scan.angle_min_rad = -M_PI / 2;
  record.scan.angle_step_rad = M_PI / 360;
  record.scan.range_max_m = 80.0;
  for (int i = 0; i < 361; ++i) record.scan.ranges_m.push_back(0.0123f * static_cast<float>(i));
  record.scan.ranges_m[7] = std::numeric_limits<float>::quiet_NaN();
  record.scan.ranges_m[8] = std::numeric_limits<float>::infinity();
  const LogRecord back = only_record(carmen_line(record) + "\n");
  EXPECT_EQ(back.scan.sensor, "robotlaser1");
  EXPECT_NEAR(back.stamp_s, record.stamp_s, 5e-7);
  // 9 decimals, and the sensor pose is a difference of two poses of 9 decimals, 13 m from the origin.
  expect_near(back.odometry, {12.25, -3.5, 3.0}, 1e-9, 1e-9);
  expect_near(back.scan.T_base_sensor, {0.17, -0.02, 0.3}, 1e-8, 1e-8);
  EXPECT_NEAR(back.scan.angle_min_rad, -M_PI / 2, 1e-9);
  EXPECT_NEAR(back.scan.angle_step_rad, M_PI / 360, 1e-11) << "from the field of view: 360 times finer";
  EXPECT_EQ(back.scan.range_max_m, 80.0);
  ASSERT_EQ(back.scan.ranges_m.size(), 361u);
  EXPECT_TRUE(std::isnan(back.scan.ranges_m[7]));
  EXPECT_TRUE(std::isinf(back.scan.ranges_m[8]));
  for (std::size_t i = 9; i < 361; ++i) EXPECT_NEAR(back.scan.ranges_m[i], record.scan.ranges_m[i], 5.1e-5);
}

}  // namespace
}  // namespace parloc
