// What CARMEN lines do not say of a LiDAR: PARAM lines, angles by the number of beams, rounded steps, places
// that move; and odd ways to write numbers.
#include "common/io/carmen_params.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/io/log_notes.h"
#include "common/io/scan_stream.h"
#include "tests/unit/expect.h"
#include "tests/unit/whole_log.h"

namespace parloc {
namespace {

using test::Read;
using test::read_text;
constexpr double kDeg = M_PI / 180.0;

std::string laser(const std::string& name, std::size_t beams) {
  std::string line = name + " " + std::to_string(beams);
  for (std::size_t i = 0; i < beams; ++i) line += " 1.50";
  return line + " 9 9 9 1.0 2.0 0.5 100.250000 host 0.1\n";
}

std::string param(const std::string& name_and_value) {
  return "PARAM " + name_and_value + " host 0\n";
}

/// The only scan of a text without a broken line.
Scan scan_of(const std::string& text) {
  const Read read = read_text(text);
  EXPECT_EQ(read.records.size(), 1u) << text.substr(0, 200);
  EXPECT_EQ(read.warnings.broken_lines, 0u) << text.substr(0, 200);
  return read.records.size() == 1 ? read.records[0].scan : Scan{};
}

void expect_degrees(const Scan& scan, double first_deg, double step_deg, double tolerance_deg = 1e-9) {
  EXPECT_NEAR(scan.angle_min_rad / kDeg, first_deg, tolerance_deg) << scan.ranges_m.size();
  EXPECT_NEAR(scan.angle_step_rad / kDeg, step_deg, tolerance_deg / 100) << scan.ranges_m.size();
}

TEST(CarmenAngles, CountsThatAreNoHalfCircle) {
  constexpr double urg = 360.0 / 1024.0;
  expect_degrees(scan_of(laser("FLASER", 541)), -135.0, 0.5);
  expect_degrees(scan_of(laser("FLASER", 540)), -135.0, 0.5);
  expect_degrees(scan_of(laser("FLASER", 1081)), -135.0, 0.25);
  expect_degrees(scan_of(laser("RLASER", 682)), -340.5 * urg, urg);
  expect_degrees(scan_of(laser("FLASER", 683)), -341.0 * urg, urg);
  expect_degrees(scan_of(laser("FLASER", 769)), -135.0, urg);
}

TEST(CarmenAngles, ParamsComeBeforeTheCount) {
  const auto with = [](const std::string& step, const std::string& view, std::size_t beams) {
    return scan_of((step.empty() ? "" : param("laser_front_laser_resolution " + step)) +
                   (view.empty() ? "" : param("laser_front_laser_fov " + view)) + laser("FLASER", beams));
  };
  expect_degrees(with("0.2500", "100.000", 401), -50.0, 0.25);
  expect_degrees(with("0.25", "", 401), -50.0, 0.25);
  expect_degrees(with("", "100", 401), -50.0, 0.25);
  expect_degrees(with("0.25", "", 400), -50.0, 0.25);
  expect_degrees(with("0.3", "", 541), -81.0, 0.3);
  expect_degrees(with("0.25", "135", 541), -67.5, 0.25);
  expect_degrees(with("0.3516", "239.766", 683), -341 * 360.0 / 1024.0, 360.0 / 1024.0);
  expect_degrees(with("0.5", "", 321), -80.0, 0.5);
  expect_degrees(with("0.33", "220", 661), -110.0, 1.0 / 3.0);
  expect_degrees(with("1", "360", 360), -180.0, 1.0);
}

TEST(CarmenAngles, ParamsThatSayWhatIsKnownChangeNoBit) {
  for (const std::size_t beams : {180, 181, 360, 361, 541, 683}) {
    const Scan plain = scan_of(laser("FLASER", beams));
    const std::string step = beams < 200 ? "1.0" : beams == 683 ? "0.352" : "0.5";
    const std::string view = beams < 400 ? "180" : beams == 541 ? "270.0" : "240";
    const Scan said = scan_of(param("laser_front_laser_resolution " + step) +
                              param("laser_front_laser_fov " + view) + laser("FLASER", beams));
    EXPECT_EQ(said.angle_min_rad, plain.angle_min_rad) << beams;
    EXPECT_EQ(said.angle_step_rad, plain.angle_step_rad) << beams;
  }
}

TEST(CarmenAngles, WhatIsGuessedIsSaidOnce) {
  const Read read =
      read_text(laser("FLASER", 401) + laser("FLASER", 401) + laser("FLASER", 403) + laser("RLASER", 361));
  ASSERT_EQ(read.warnings.notes.size(), 1u);
  expect_parts(read.warnings.notes[0].text,
               {"front", "401 beams", "-90 to 90", "0.45", "lidars.front.angle_min and angle_step"});
  LidarConfig front{.name = "front"};
  EXPECT_EQ(open_notes(read.warnings.notes, {front}).size(), 1u);
  front.angle_min = front.angle_step = 0.1;
  EXPECT_TRUE(open_notes(read.warnings.notes, {front}).empty()) << "the settings decide it";
}

TEST(CarmenAngles, ParamsThatContradictAreSaid) {
  const Read read = read_text(param("laser_front_laser_resolution 0.5") + param("laser_front_laser_fov 180") +
                              laser("FLASER", 181));
  ASSERT_EQ(read.warnings.notes.size(), 1u);
  expect_parts(read.warnings.notes[0].text, {"180 degrees in steps of 0.5", "181 beams"});
  expect_degrees(read.records.at(0).scan, -90.0, 1.0);  // as the count and one of the two say
}

TEST(CarmenAngles, RoundedStepsAreFoundOut) {
  const auto step_of = [](const std::string& view, const std::string& step, std::size_t beams) {
    std::string line = "ROBOTLASER1 0 -1 " + view + " " + step + " 8 0.01 0 " + std::to_string(beams);
    for (std::size_t i = 0; i < beams; ++i) line += " 1";
    return scan_of(line + " 0 0 0 0 0 0 0 0 0 0 0 0 5 h 0\n").angle_step_rad;
  };
  EXPECT_DOUBLE_EQ(step_of("4.7124", "0.0044", 1081), 4.7124 / 1080);
  EXPECT_DOUBLE_EQ(step_of("4.712", "0.004", 1081), 4.712 / 1080);
  EXPECT_DOUBLE_EQ(step_of("4.7124", "0.0087", 541), 4.7124 / 540) << "one end counted is nearer: no matter";
  EXPECT_DOUBLE_EQ(step_of("3.1416", "0.0175", 181), 3.1416 / 180);
  EXPECT_DOUBLE_EQ(step_of("3.14159", "0.00873", 361), 3.14159 / 360);
  EXPECT_DOUBLE_EQ(step_of("3.1416", "0.0175", 180), 3.1416 / 180) << "only one end counted fits";
  EXPECT_DOUBLE_EQ(step_of("6.2832", "0.0175", 360), 6.2832 / 360) << "a whole turn ends where it began";
  EXPECT_DOUBLE_EQ(step_of("-4.7124", "-0.0044", 1081), -4.7124 / 1080) << "clockwise";
  EXPECT_DOUBLE_EQ(step_of("4.7124", "0.0051", 1081), 0.0051) << "no rounding of it";
}

TEST(CarmenParams, MountOfBothLasers) {
  const Read read =
      read_text(param("robot_frontlaser_offset 0.2") + param("robot_frontlaser_side_offset 0.15") +
                param("robot_frontlaser_angular_offset 0.349") + param("robot_rearlaser_offset 0.3") +
                param("robot_rearlaser_side_offset -0.1") + param("robot_rearlaser_angular_offset 3.0") +
                laser("FLASER", 181) + laser("RLASER", 181));
  ASSERT_EQ(read.records.size(), 2u);
  expect_near(read.records[0].scan.T_base_sensor, {0.2, 0.15, 0.349}, 0.0, 1e-15);
  expect_near(read.records[1].scan.T_base_sensor, {-0.3, -0.1, 3.0}, 0.0, 1e-15);
}

TEST(CarmenParams, FlippedAndRangesByNameAndById) {
  for (const char* yes : {"1", "on", "ON", "true"})
    EXPECT_TRUE(
        scan_of(param(std::string("laser_front_laser_flipped ") + yes) + laser("FLASER", 9)).upside_down);
  for (const char* no : {"0", "off", "False", "no"})
    EXPECT_FALSE(
        scan_of(param(std::string("laser_front_laser_flipped ") + no) + laser("FLASER", 9)).upside_down);
  EXPECT_TRUE(scan_of(param("laser_rear_laser_flipped 1") + laser("RLASER", 9)).upside_down);
  EXPECT_FALSE(scan_of(param("laser_rear_laser_flipped 1") + laser("FLASER", 9)).upside_down);
  EXPECT_EQ(scan_of(param("robot_front_laser_max 20.5") + laser("FLASER", 9)).range_max_m, 20.5);
  EXPECT_EQ(scan_of(param("laser_front_laser_max_range 8") + laser("FLASER", 9)).range_max_m, 8.0);
  expect_degrees(scan_of(param("laser_laser1_resolution 0.25") + laser("FLASER", 401)), -50.0, 0.25);
  expect_degrees(scan_of(param("laser_laser2_fov 100") + laser("RLASER", 401)), -50.0, 0.25);
  expect_degrees(
      scan_of(param("laser_laser4_fov 100") + param("robot_frontlaser_id 4") + laser("FLASER", 401)), -50.0,
      0.25);
}

TEST(CarmenParams, ValuesOutOfBoundsAreBrokenLines) {
  for (const char* line :
       {"laser_front_laser_resolution 0", "laser_front_laser_resolution -0.5",
        "laser_front_laser_resolution nan", "laser_front_laser_fov 3.14159", "laser_front_laser_fov 700",
        "laser_rear_laser_fov wide", "laser_front_laser_flipped 2", "laser_front_laser_flipped",
        "robot_frontlaser_side_offset 1e9", "robot_frontlaser_angular_offset 180", "robot_front_laser_max 0",
        "robot_frontlaser_id 10", "laser_laser3_resolution x"}) {
    const Read read = read_text(param(line) + laser("FLASER", 9));
    EXPECT_EQ(read.warnings.broken_lines, 1u) << line;
    EXPECT_EQ(read.records.size(), 1u) << line;
  }
  const Read read = read_text(param("laser_front_laser_resolution 90") + laser("FLASER", 99));
  EXPECT_EQ(read.warnings.broken_lines, 1u);
  expect_parts(read.warnings.messages.at(0), {"expected beams within two turns", "90 degrees (PARAM)"});
}

std::string robotlaser(const Pose& laser, const Pose& robot, int k) {
  LogRecord record;
  record.odometry = robot;
  record.scan.T_base_sensor = relative(laser, robot);
  record.scan.stamp_s = k;
  record.scan.sensor = "robotlaser1";
  record.scan.angle_step_rad = 0.1;
  record.scan.ranges_m = {1.0f, 2.0f};
  return carmen_line(record) + "\n";
}

TEST(MountWatch, APlaceThatChangesIsSaidOnceAndAtOnce) {
  std::string zero, fixed, heading;
  for (int k = 0; k < 40; ++k) {
    const Pose robot{0.1 * k, 0.0, 0.05 * k};
    zero += robotlaser({}, robot, k);
    fixed += robotlaser(compose(robot, {0.2, 0.03 + 0.01 * (k % 2), 0.02 * (k % 2)}), robot, k);
    heading += robotlaser({robot.x_m, robot.y_m, 0.0}, robot, k);
  }
  const Read read = read_text(zero);
  ASSERT_EQ(read.warnings.notes.size(), 1u);
  expect_parts(read.warnings.notes[0].text, {"robotlaser1", "in line 4", "lidars.robotlaser1.x, y and yaw"});
  EXPECT_EQ(read.warnings.notes[0].about, LogNote::About::mount);
  EXPECT_EQ(read_text(heading).warnings.notes.size(), 1u);
  EXPECT_TRUE(read_text(fixed).warnings.notes.empty()) << "rounding, and poses a little apart in time";
  const LidarConfig told{.name = "robotlaser1", .x = 0.0, .y = 0.0, .yaw = 0.0};
  EXPECT_TRUE(open_notes(read.warnings.notes, {told}).empty());
}

TEST(CarmenLog, ALogWithoutScansSaysWhatItHas) {
  std::string text;
  for (int k = 0; k < 5; ++k) text += "TRUEPOS 1 2 0 1 2 0 1 h 1\n";
  const Read read = read_text(text + "LASER_LDMRS 1 2 3\nODOM 1 2 3 0 0 0 1 h 0\n");
  EXPECT_EQ(std::string(no_scan("x.log", read.warnings).what()),
            "x.log: expected at least one scan (FLASER, RLASER or ROBOTLASER1), found none; 5 TRUEPOS, "
            "1 LASER_LDMRS lines: not read");
}

std::string raw_laser(double stamp_s, int number = 1) {
  return fmt::format("RAWLASER{} 0 -1.5 3 1.5 81 0.01 0 3 1 2 3 0 {} h 1\n", number, stamp_s);
}

TEST(CarmenLog, RawScansGetTheOdometryAtTheirTime) {
  const std::string params =
      "PARAM robot_frontlaser_offset 0.25 1 h 0\nPARAM robot_rearlaser_offset 0.5 1 h 0\nPARAM "
      "laser_laser3_flipped 1 1 h 0\n";
  const std::string odometry = "ODOM 0 0 0 0 0 0 1 h 0\nODOM 2 4 0.5 0 0 0 2 h 0\nODOM 3 4 0.5 0 0 0 3 h 0\n";
  const Read read = read_text(params + raw_laser(0.5) + raw_laser(1.5) + raw_laser(2.0, 2) +
                              raw_laser(2.5, 3) + odometry + raw_laser(9.0));
  std::vector<LogRecord> scans;
  for (const LogRecord& record : read.records)
    if (record.kind == RecordKind::scan) scans.push_back(record);
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_EQ(scans[0].scan.sensor, "rawlaser1");
  expect_near(scans[0].odometry, {1.0, 2.0, 0.25}, 1e-12, 1e-12);
  expect_equal(scans[0].scan.T_base_sensor, {0.25, 0.0, 0.0});
  EXPECT_EQ(scans[0].scan.range_max_m, 81.0);
  EXPECT_EQ(scans[0].scan.angle_step_rad, 1.5);
  expect_near(scans[1].odometry, {2.0, 4.0, 0.5}, 0.0, 0.0);
  EXPECT_EQ(scans[1].scan.T_base_sensor.x_m, -0.5);
  EXPECT_TRUE(scans[2].scan.upside_down);
  ASSERT_EQ(read.warnings.messages.size(), 2u);
  EXPECT_EQ(read.warnings.messages[0], "x.log: 1 scan before the first odometry left out");
  EXPECT_EQ(read.warnings.messages[1], "x.log: 1 scan after the last odometry left out");
}

TEST(CarmenLog, RawScansBesideOthersAreNotRead) {
  const Read read =
      read_text(raw_laser(1.5) + "ODOM 0 0 0 0 0 0 1 h 0\nFLASER 2 1 1 0 0 0 1 2 0.5 1.5 host 0.1\n");
  ASSERT_EQ(read.records.size(), 2u);
  ASSERT_EQ(read.warnings.unread.size(), 1u);
  EXPECT_EQ(read.warnings.unread[0].first, "RAWLASER1");
}

TEST(CarmenLog, RawScansWithoutOdometry) {
  const auto log = carmen_log_from_text(raw_laser(1.0), "x.log");
  LogRecord record;
  EXPECT_EQ(error_of([&] { log->next(record); }),
            "x.log: 1 scans say no odometry (RAWLASER): expected odometry, found scans alone");
  const auto alone = carmen_log_from_text(raw_laser(1.0), "x.log", true);
  ASSERT_TRUE(alone->next(record));
  expect_equal(record.odometry, {});
}

TEST(CarmenLog, OddWaysToWriteNumbersAndLines) {
  const Scan scan = scan_of(
      "\xEF\xBB\xBF"
      "FLASER\t8 1.#INF -1.#IND 1.#QNAN\t-1.#INF 1.#INF00 INF NaN 2.5 0 0 0 1 2 0.5 100.25 host 0.1\r\n");
  ASSERT_EQ(scan.ranges_m.size(), 8u);
  constexpr float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(scan.ranges_m[0], inf);
  EXPECT_TRUE(std::isnan(scan.ranges_m[1]) && std::isnan(scan.ranges_m[2]) && std::isnan(scan.ranges_m[6]));
  EXPECT_EQ(scan.ranges_m[3], -inf);
  EXPECT_EQ(scan.ranges_m[4], inf);
  EXPECT_EQ(scan.ranges_m[5], inf);
  EXPECT_EQ(scan.ranges_m[7], 2.5f);
  EXPECT_EQ(read_text("ODOM 1.#INF 0 0 0 0 0 1 h 1\n").warnings.broken_lines, 1u) << "no place";
  EXPECT_EQ(read_text("FLASER 1 1.#IN 0 0 0 0 0 0 1 h 1\n").warnings.broken_lines, 1u);
}

TEST(CarmenLine, AnUpsideDownScanReadsBackWithItsAngles) {
  Read read = read_text(param("laser_front_laser_flipped on") + laser("FLASER", 180));
  const Scan back = scan_of(carmen_line(read.records.at(0)) + "\n");
  EXPECT_FALSE(back.upside_down);
  expect_degrees(back, 90.0, -1.0, 1e-6);
}

}  // namespace
}  // namespace parloc
