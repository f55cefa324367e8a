// A scan's answer as a row of CSV and as an object of JSON.
#include "tools/run/pose_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace parloc::tools {
namespace {

using Json = nlohmann::json;

std::vector<std::string> cells(std::string row) {
  EXPECT_EQ(row.back(), '\n');
  row.back() = ',';
  std::istringstream text(row);
  std::vector<std::string> found;
  for (std::string cell; std::getline(text, cell, ',');) found.push_back(cell);
  return found;
}

/// Numbers that no short text of a fixed length reads back to.
LocalizerEstimate awkward() {
  LocalizerEstimate e;
  e.filter.pose = {0.1 + 0.2, -1.0 / 3.0, 1e-17};
  for (int k = 0; k < 9; ++k) e.filter.covariance.v[k] = 1.0 / (k + 7.0);
  e.filter.n_eff = 1234.5678901234567;
  e.filter.particles = 2000;
  e.filter.weighted = true;
  e.health = {2.0 / 3.0, std::sqrt(2.0), 1.5, HealthState::ambiguous};
  e.modes = {{{1.0 / 7.0, 2.0, 3.0}, 0.6}, {{-4.0, 5.5, -0.25}, 0.4}};
  e.searched = true;
  return e;
}

const std::vector<std::string> kNumbers{"x_m",
                                        "y_m",
                                        "theta_rad",
                                        "covariance_xx_m2",
                                        "covariance_xy_m2",
                                        "covariance_xt_m_rad",
                                        "covariance_yy_m2",
                                        "covariance_yt_m_rad",
                                        "covariance_tt_rad2",
                                        "probability",
                                        "evidence",
                                        "n_eff"};

std::vector<double> numbers_of(const LocalizerEstimate& e) {
  const double* c = e.filter.covariance.v;
  return {
      e.filter.pose.x_m,    e.filter.pose.y_m, e.filter.pose.theta_rad, c[0], c[1], c[2], c[4], c[5], c[8],
      e.health.probability, e.health.evidence, e.filter.n_eff};
}

TEST(PoseFile, ARowOfCsvReadsBackToTheSameNumbers) {
  const LocalizerEstimate e = awkward();
  const std::vector<std::string> names = cells(csv_header());
  const std::vector<std::string> row = cells(csv_row({1137772793.094853, e, true, 97}));
  ASSERT_EQ(names.size(), 19u);
  ASSERT_EQ(row.size(), names.size());
  const auto at = [&](const std::string& name) {
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k] == name) return row[k];
    ADD_FAILURE() << "no column " << name;
    return std::string();
  };
  const std::vector<double> numbers = numbers_of(e);
  for (std::size_t k = 0; k < numbers.size(); ++k)
    EXPECT_EQ(std::strtod(at(kNumbers[k]).c_str(), nullptr), numbers[k]) << kNumbers[k];
  EXPECT_EQ(at("x_m"), "0.30000000000000004");  // no longer than it must be
  EXPECT_EQ(at("stamp_s"), "1137772793.094853");
  EXPECT_EQ(at("state"), "ambiguous");
  EXPECT_EQ(at("particles"), "2000");
  EXPECT_EQ(at("beams_used"), "97");
  EXPECT_EQ(at("weighted"), "1");
  EXPECT_EQ(at("searched"), "1");
  EXPECT_EQ(at("hypotheses"), "2");
}

TEST(PoseFile, AnObjectOfJsonSaysTheSameAndNamesTheHypotheses) {
  const LocalizerEstimate e = awkward();
  const std::string line = jsonl_row({12.5, e, true, 97});
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const Json j = Json::parse(line);
  const std::vector<double> numbers = numbers_of(e);
  for (std::size_t k = 0; k < numbers.size(); ++k) EXPECT_EQ(j.at(kNumbers[k]), numbers[k]) << kNumbers[k];
  EXPECT_EQ(j.size(), cells(csv_header()).size());
  for (const std::string& name : cells(csv_header())) EXPECT_TRUE(j.contains(name)) << name;
  EXPECT_EQ(j.at("stamp_s"), 12.5);
  EXPECT_EQ(j.at("state"), "ambiguous");
  EXPECT_EQ(j.at("weighted"), true);
  EXPECT_EQ(j.at("searched"), true);
  EXPECT_EQ(j.at("hypotheses"),
            Json::parse(R"([{"x_m": 0.14285714285714285, "y_m": 2.0, "theta_rad": 3.0, "weight": 0.6},
                            {"x_m": -4.0, "y_m": 5.5, "theta_rad": -0.25, "weight": 0.4}])"));
}

TEST(PoseFile, WhatIsNotKnownIsEmptyOrNull) {
  LocalizerEstimate e;
  e.filter.covariance.v[0] = std::numeric_limits<double>::quiet_NaN();
  e.filter.covariance.v[4] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(csv_row({0.0, e, false, 0}), "0.000000,0,0,0,,0,0,,0,0,,,,0,0,0,0,0,0\n");
  const Json j = Json::parse(jsonl_row({0.0, e, false, 0}));
  for (const char* name : {"covariance_xx_m2", "covariance_yy_m2", "state", "probability", "evidence"})
    EXPECT_TRUE(j.at(name).is_null()) << name;
  EXPECT_EQ(j.at("hypotheses"), Json::array());
  EXPECT_EQ(j.at("weighted"), false);
}

}  // namespace
}  // namespace parloc::tools
