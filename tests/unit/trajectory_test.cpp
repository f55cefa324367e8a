#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <utility>

#include "common/io/trajectory.h"
#include "tests/unit/expect.h"
#include "tests/unit/real_data.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::TempFile;

TEST(Tum, ReadsRowsInFileOrder) {
  const Trajectory t = tum_from_text(
      "# timestamp x y z qx qy qz qw\n\n"
      " 976052857.337530 1.5 -2.5 0 0 0 0.7071067811865476 0.7071067811865476\r\n"
      "976052856.5\t3 4 9 0 0 0 1",
      "t.tum");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].stamp_s, 976052857.337530);
  expect_near(t[0].pose, {1.5, -2.5, M_PI / 2}, 0.0, 1e-15);
  EXPECT_EQ(t[1].stamp_s, 976052856.5) << "a stamp that runs backwards stays where it is";
}

TEST(Tum, HeadingIsTheYawOfAnyQuaternion) {
  // yaw 2.5, pitch 0.2, roll -0.1 as z-y-x rotations.
  const double cy = std::cos(1.25), sy = std::sin(1.25), cp = std::cos(0.1), sp = std::sin(0.1);
  const double cr = std::cos(-0.05), sr = std::sin(-0.05);
  std::ostringstream row;
  row.precision(17);
  row << "1 0 0 0 " << sr * cp * cy - cr * sp * sy << ' ' << cr * sp * cy + sr * cp * sy << ' '
      << cr * cp * sy - sr * sp * cy << ' ' << cr * cp * cy + sr * sp * sy;
  const auto yaw_of = [](const std::string& text) { return tum_from_text(text, "t.tum")[0].pose.theta_rad; };
  EXPECT_NEAR(yaw_of(row.str()), 2.5, 1e-14);
  // The same rotation with the other sign, and one that is not quite of unit length.
  const double yaw_rad = 2 * std::atan2(0.6, 0.8);
  EXPECT_NEAR(yaw_of("1 0 0 0 0 0 -0.6 0.8"), -yaw_rad, 1e-15);
  EXPECT_NEAR(yaw_of("1 0 0 0 0 0 0.6 -0.8"), -yaw_rad, 1e-15);
  EXPECT_NEAR(yaw_of("1 0 0 0 0 0 0.603 0.804"), yaw_rad, 1e-15);
}

TEST(Tum, FlaserLinesAreATrajectoryToo) {
  const Trajectory t = tum_from_text(
      "# CARMEN Logfile\nPARAM robot_length 1 h 0\nODOM 9 9 9 0 0 0 1 h 1\n"
      "FLASER 0 1.5 -2.5 4.0 7 8 9 100.250000 nohost 0.5\nSYNC x 1 h 1\n"
      "FLASER 2 3.0 4.0 1 2 0.5 7 8 9 99.5 nohost 0.5\r\n",
      "t.log");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].stamp_s, 100.25);
  expect_near(t[0].pose, {1.5, -2.5, 4.0 - 2.0 * M_PI}, 0.0, 1e-15);
  EXPECT_EQ(t[1].stamp_s, 99.5);
  expect_near(t[1].pose, {1.0, 2.0, 0.5}, 0.0, 0.0);
  EXPECT_EQ(error_of([] { tum_from_text("FLASER 0 1 2 x 0 0 0 1 h 1\n", "t.log"); }),
            "t.log:1: expected a finite heading, found 'x'");
  EXPECT_EQ(error_of([] { tum_from_text("ODOM 1 2 3 0 0 0 1 h 1\n", "t.log"); }),
            "t.log: expected a FLASER line with a pose, found none");
  EXPECT_EQ(error_of([] { tum_from_text("FLASER 99 1 2 3 0 0 0 1 h\n", "t.log"); }),
            "t.log:1: expected a number of ranges, found 99, more than the line holds");
}

TEST(Tum, ErrorsNameFileLineAndWhatWasExpected) {
  const std::pair<std::string, const char*> cases[] = {
      {"# c\n1 2 3 0 0 0 0\n", "t.tum:2: expected a unit quaternion, found the end of the line"},
      {"1 2 3 0 0 0 0 1 9\n", "t.tum:1: expected 8 numbers: timestamp x y z qx qy qz qw, found '9'"},
      {"1 2 x 0 0 0 0 1\n", "t.tum:1: expected a finite position, found 'x'"},
      {"1 2 nan 0 0 0 0 1\n", "t.tum:1: expected a finite position, found 'nan'"},
      {"1 2 3 0 0 0 0 0\n", "t.tum:1: expected a unit quaternion, found one of length 0"},
      {"1 2 3 0 0 0 0.5 0.5\n", "t.tum:1: expected a unit quaternion, found one of length 0.7071"},
      {"# nothing\n", "t.tum: expected a pose, found none"},
      {"", "t.tum: expected a pose, found none"},
      {std::string(2 << 20, '1'), "t.tum:1: expected 8 numbers, found a line of more than a mebibyte"},
  };
  for (const auto& [text, message] : cases)
    EXPECT_EQ(error_of([&t = text] { tum_from_text(t, "t.tum"); }), message);
  EXPECT_THROW(read_tum("no/such.tum"), Error);
}

TEST(Tum, RoundTrip) {
  Trajectory t;
  for (int i = 0; i < 200; ++i) {
    t.push_back({976052857.0 + 0.123456 * i, {0.1 * i, -0.2 * i, -3.14 + 0.0314 * i}});
  }
  const TempFile file("track.tum", "something old\n");
  write_tum(file.path(), t);
  const Trajectory back = read_tum(file.path());
  ASSERT_EQ(back.size(), t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    EXPECT_NEAR(back[i].stamp_s, t[i].stamp_s, 6e-7);    // 6 decimals, and a double's own 1e-7 there
    expect_near(back[i].pose, t[i].pose, 5.1e-7, 2e-9);  // 9 decimals of half an angle
  }
  std::ifstream stream(file.path());
  std::string header, row;
  std::getline(stream, header);
  std::getline(stream, row);
  EXPECT_EQ(row.rfind("976052857.000000 ", 0), 0u) << row;
}

TEST(Tum, WriteFailureLeavesNothingBehind) {
  const TempFile folder("folder");
  std::filesystem::remove(folder.path());
  std::filesystem::create_directories(folder.path() + "/taken");
  const Trajectory t{{1.0, {}}};
  for (const char* path : {"/missing/track.tum", "/taken"})  // a folder has the name of the second
    error_of([&] { write_tum(folder.path() + path, t); }, ErrorKind::output);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1)
      << "no temporary file stays";
  std::filesystem::remove_all(folder.path());
}

TEST(RealTrajectory, IntelReference) {
  const std::string path = test::real_data("intel/reference.tum");
  PARLOC_NEEDS_FILE(path);
  const Trajectory t = read_tum(path);
  EXPECT_EQ(t.size(), 13631u);
  EXPECT_EQ(t[0].stamp_s, 976052857.337530);
}

}  // namespace
}  // namespace parloc
