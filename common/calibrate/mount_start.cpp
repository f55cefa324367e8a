#include "common/calibrate/mount_start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/portable64.h"
#include "common/math/quantile.h"

namespace parloc {
namespace {

constexpr int kDelaySteps = 30;  // to either side of 0
constexpr double kDelayStep_s = 0.02;
constexpr int kRounds = 12;

struct Turns {
  double ratio = 1.0;  ///< Odometry's over the scans'.
  double cost = 0.0;
};

/// Of headings at one delay: the ratio by least squares with the weights of Cauchy.
Turns turns_at(const std::vector<PairMotion>& pairs, const OdometryPath& path, double delay_s) {
  std::vector<double> by_odometry, by_scans;
  for (const PairMotion& p : pairs) {
    by_odometry.push_back(path.raw_heading_rad(p.to_s + delay_s) - path.raw_heading_rad(p.from_s + delay_s));
    by_scans.push_back(p.step.theta_rad);
  }
  constexpr double kWidth_rad = 0.05;
  Turns turns;
  for (int round = 0; round < kRounds; ++round) {
    double product = 0.0, square = 0.0;
    turns.cost = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const double e = (by_odometry[k] - turns.ratio * by_scans[k]) / kWidth_rad;
      const double weight = 1.0 / (1.0 + e * e);
      product += weight * by_odometry[k] * by_scans[k];
      square += weight * by_scans[k] * by_scans[k];
      turns.cost += portable_log64(1.0 + e * e);
    }
    // As good as no turn leaves the ratio at 1.
    constexpr double kNothing_rad_sq = 0.01;
    turns.ratio = std::clamp((product + kNothing_rad_sq) / (square + kNothing_rad_sq), 0.5, 2.0);
  }
  return turns;
}

/// Place and cosine and sine of the yaw, over the scale of drive.
std::array<double, 4> linear_mount(const std::vector<PairMotion>& pairs, const std::vector<Pose>& odometry) {
  std::array<double, 4> at{};
  double width_m = 1.0;
  std::vector<double> errors(2 * pairs.size(), 0.0);
  for (int round = 0; round < kRounds; ++round) {
    NormalEquations<4> equations;
    for (std::size_t i = 0; i < 4; ++i) equations.matrix[i][i] = 1e-4;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Pose& s = pairs[k].step;
      const SinCos64 turn = portable_sincos64(s.theta_rad);
      const std::array<std::array<double, 4>, 2> rows{
          {{1.0 - turn.cos, turn.sin, s.x_m, -s.y_m}, {-turn.sin, 1.0 - turn.cos, s.y_m, s.x_m}}};
      const std::array<double, 2> values{odometry[k].x_m, odometry[k].y_m};
      const double e_sq =
          (errors[2 * k] * errors[2 * k] + errors[2 * k + 1] * errors[2 * k + 1]) / (width_m * width_m);
      for (std::size_t axis = 0; axis < 2; ++axis)
        equations.add(rows[axis], values[axis], 1.0 / (1.0 + e_sq));
    }
    const std::array<double, 4> right = equations.right;
    if (!equations.factor()) return at;
    at = equations.solve(right);
    std::vector<double> sizes;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Pose& s = pairs[k].step;
      const SinCos64 turn = portable_sincos64(s.theta_rad);
      errors[2 * k] =
          odometry[k].x_m - ((1.0 - turn.cos) * at[0] + turn.sin * at[1] + s.x_m * at[2] - s.y_m * at[3]);
      errors[2 * k + 1] =
          odometry[k].y_m - (-turn.sin * at[0] + (1.0 - turn.cos) * at[1] + s.y_m * at[2] + s.x_m * at[3]);
      sizes.push_back(std::fabs(errors[2 * k]) + std::fabs(errors[2 * k + 1]));
    }
    width_m = std::max(2.0 * median(ascending(std::move(sizes))), 0.01);
  }
  return at;
}

}  // namespace

Unknowns start_of(const std::vector<PairMotion>& pairs, OdometryPath& path) {
  Unknowns start{};
  Turns best{1.0, std::numeric_limits<double>::infinity()};
  for (int k = 0; k <= 2 * kDelaySteps; ++k) {  // 0 first, then to either side: of equals the smaller counts
    const double delay_s = (k % 2 == 0 ? 1.0 : -1.0) * ((k + 1) / 2) * kDelayStep_s;
    const Turns turns = turns_at(pairs, path, delay_s);
    if (turns.cost < best.cost) best = turns, start[kDelay] = delay_s;
  }
  start[kTurn] = -portable_log64(best.ratio);
  OdometryScales scales;
  scales.turn = 1.0 / best.ratio;
  path.set_scales(scales);
  std::vector<Pose> odometry;
  for (const PairMotion& p : pairs)
    odometry.push_back(relative(path.at(p.to_s + start[kDelay]), path.at(p.from_s + start[kDelay])));
  const std::array<double, 4> mount = linear_mount(pairs, odometry);
  const double length = std::sqrt(mount[2] * mount[2] + mount[3] * mount[3]);
  const double scale = std::clamp(1.0 / std::max(length, 1e-3), 0.5, 2.0);
  start[kYaw] = portable_atan2_64(mount[3], mount[2]);
  start[kDrive] = start[kSide] = portable_log64(scale);
  start[kX] = scale * mount[0], start[kY] = scale * mount[1];
  return start;
}

}  // namespace parloc
