// What many tests expect: an error and its words, parts of a text, poses.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>

#include "common/error.h"
#include "common/math/pose.h"

namespace parloc {

/// The message of the Error of this kind that `body` throws; empty, and a failure, if it throws none.
template <class Body>
std::string error_of(Body&& body, ErrorKind kind = ErrorKind::input) {
  try {
    body();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), kind) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

inline void expect_parts(const std::string& text, std::initializer_list<std::string> parts) {
  for (const std::string& part : parts)
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in\n" << text;
}
inline void expect_none_of(const std::string& text, std::initializer_list<std::string> parts) {
  for (const std::string& part : parts)
    EXPECT_EQ(text.find(part), std::string::npos) << "'" << part << "' in\n" << text;
}

inline void expect_near(const Pose& a, const Pose& b, double tolerance_m, double tolerance_rad) {
  EXPECT_NEAR(a.x_m, b.x_m, tolerance_m);
  EXPECT_NEAR(a.y_m, b.y_m, tolerance_m);
  EXPECT_NEAR(a.theta_rad, b.theta_rad, tolerance_rad);
}
inline void expect_equal(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.x_m, b.x_m);
  EXPECT_EQ(a.y_m, b.y_m);
  EXPECT_EQ(a.theta_rad, b.theta_rad);
}

}  // namespace parloc
