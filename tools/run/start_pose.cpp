#include "tools/run/start_pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "tools/program/parse_number.h"

namespace parloc::tools {
namespace {

std::vector<double> parse_numbers(const std::string& text) {
  std::vector<double> numbers;
  for (std::string word : split_at_commas(text)) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.erase(0, 1);  // from_chars knows no '+'
    double value = 0.0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      throw Error(ErrorKind::usage, fmt::format("--init {}: expected finite numbers, got '{}'", text, word));
    }
    numbers.push_back(value);
  }
  return numbers;
}

}  // namespace

StartPose parse_start_pose(const std::string& text, const Config& config) {
  StartPose start;
  start.anywhere = text == "global";
  if (start.anywhere) return start;
  const std::vector<double> v = parse_numbers(text);
  if (v.size() != 3 && v.size() != 6) {
    throw Error(ErrorKind::usage,
                fmt::format("--init {}: expected x,y,theta or x,y,theta,sx,sy,st or global, got {} number{}",
                            text, v.size(), v.size() == 1 ? "" : "s"));
  }
  constexpr double turn_rad = 6.2832;
  if (std::fabs(v[2]) > turn_rad) {
    throw Error(ErrorKind::usage, fmt::format("--init {}: theta is in radians, -2 pi to 2 pi", text));
  }
  start.pose = compose(Pose{v[0], v[1], v[2]}, Pose{});  // wraps theta
  start.sigma_x_m = v.size() == 6 ? v[3] : config.initial_sigma_xy;
  start.sigma_y_m = v.size() == 6 ? v[4] : config.initial_sigma_xy;
  start.sigma_theta_rad = v.size() == 6 ? v[5] : config.initial_sigma_theta;
  if (start.sigma_x_m < 0 || start.sigma_y_m < 0 || start.sigma_theta_rad < 0) {
    throw Error(ErrorKind::usage, fmt::format("--init {}: a standard deviation must not be negative", text));
  }
  return start;
}

StartPose parse_start_poses(const std::vector<std::string>& texts, const Config& config) {
  StartPose start = parse_start_pose(texts.at(0), config);
  if (texts.size() == 1) return start;
  for (const std::string& text : texts) {
    const StartPose one = parse_start_pose(text, config);
    if (one.anywhere)
      throw Error(ErrorKind::usage, "--init global: expected no other --init, several are candidate poses");
    start.guesses.push_back({one.pose, std::max(one.sigma_x_m, one.sigma_y_m), one.sigma_theta_rad, 1.0});
  }
  return start;
}

StartPose start_from_truth(const Trajectory& truth, double stamp_s, const Config& config, double max_gap_s) {
  const StampedPose* nearest = nullptr;
  double gap_s = std::numeric_limits<double>::infinity();
  for (const StampedPose& row : truth) {
    const double row_gap_s = std::fabs(row.stamp_s - stamp_s);
    if (row_gap_s < gap_s) gap_s = row_gap_s, nearest = &row;
  }
  if (nearest == nullptr || gap_s > max_gap_s) {
    throw Error(ErrorKind::input,
                fmt::format("the truth has no pose within {} s of the first scan ({:.6f} s): give the "
                            "start with --init",
                            max_gap_s, stamp_s));
  }
  return {false, nearest->pose, config.initial_sigma_xy, config.initial_sigma_xy, config.initial_sigma_theta};
}

}  // namespace parloc::tools
