#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "common/error.h"
#include "common/io/trajectory.h"
#include "tests/unit/real_data.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

using test::TempFile;

std::string error_of(const std::string& text) {
  try {
    tum_from_text(text, "t.tum");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    return error.what();
  }
  return "no error";
}

TEST(Tum, ReadsRowsInFileOrder) {
  const Trajectory t = tum_from_text(
      "# timestamp x y z qx qy qz qw\n\n 976052857.337530 1.5 -2.5 0 0 0 0.7071067811865476 "
      "0.7071067811865476\r\n"
      "976052856.5\t3 4 9 0 0 0 1",
      "t.tum");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].stamp_s, 976052857.337530);
  EXPECT_EQ(t[0].pose.x_m, 1.5);
  EXPECT_EQ(t[0].pose.y_m, -2.5);
  EXPECT_NEAR(t[0].pose.theta_rad, M_PI / 2, 1e-15);
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
  EXPECT_NEAR(tum_from_text(row.str(), "t.tum")[0].pose.theta_rad, 2.5, 1e-14);
  // The same rotation with the other sign, and one that is not quite of unit length.
  EXPECT_NEAR(tum_from_text("1 0 0 0 0 0 -0.6 0.8", "t.tum")[0].pose.theta_rad, -2 * std::atan2(0.6, 0.8),
              1e-15);
  EXPECT_NEAR(tum_from_text("1 0 0 0 0 0 0.6 -0.8", "t.tum")[0].pose.theta_rad, -2 * std::atan2(0.6, 0.8),
              1e-15);
  EXPECT_NEAR(tum_from_text("1 0 0 0 0 0 0.603 0.804", "t.tum")[0].pose.theta_rad, 2 * std::atan2(0.6, 0.8),
              1e-15);
}

TEST(Tum, ErrorsNameFileLineAndWhatWasExpected) {
  EXPECT_EQ(error_of("# c\n1 2 3 0 0 0 0\n"),
            "t.tum:2: expected a unit quaternion, found the end of the line");
  EXPECT_EQ(error_of("1 2 3 0 0 0 0 1 9\n"),
            "t.tum:1: expected 8 numbers: timestamp x y z qx qy qz qw, found '9'");
  EXPECT_EQ(error_of("1 2 x 0 0 0 0 1\n"), "t.tum:1: expected a finite position, found 'x'");
  EXPECT_EQ(error_of("1 2 nan 0 0 0 0 1\n"), "t.tum:1: expected a finite position, found 'nan'");
  EXPECT_EQ(error_of("1 2 3 0 0 0 0 0\n"), "t.tum:1: expected a unit quaternion, found one of length 0");
  EXPECT_EQ(error_of("1 2 3 0 0 0 0.5 0.5\n"),
            "t.tum:1: expected a unit quaternion, found one of length 0.7071");
  EXPECT_EQ(error_of("# nothing\n"), "t.tum: expected a pose, found none");
  EXPECT_EQ(error_of(""), "t.tum: expected a pose, found none");
  EXPECT_EQ(error_of(std::string(2 << 20, '1')),
            "t.tum:1: expected 8 numbers, found a line of more than a mebibyte");
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
    EXPECT_NEAR(back[i].stamp_s, t[i].stamp_s, 6e-7);  // 6 decimals, and a double's own 1e-7 there
    EXPECT_NEAR(back[i].pose.x_m, t[i].pose.x_m, 5.1e-7);
    EXPECT_NEAR(back[i].pose.y_m, t[i].pose.y_m, 5.1e-7);
    EXPECT_NEAR(back[i].pose.theta_rad, t[i].pose.theta_rad, 2e-9);  // 9 decimals of half an angle
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
  const auto kind_of = [&](const std::string& path) {
    try {
      write_tum(path, t);
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  };
  EXPECT_EQ(kind_of(folder.path() + "/missing/track.tum"), ErrorKind::output);
  EXPECT_EQ(kind_of(folder.path() + "/taken"), ErrorKind::output) << "a folder has that name";
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
