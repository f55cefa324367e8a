#include "common/calibrate/mount_residuals.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

OdometryScales scales_at(const Unknowns& at, bool omni) {
  const double drive = portable_exp64(at[kDrive]);
  return {drive, omni ? portable_exp64(at[kSide]) : drive, portable_exp64(at[kTurn]), at[kDrift]};
}

Matrix3 mirrored_covariance(Matrix3 c) {
  c[0][1] = -c[0][1], c[1][0] = -c[1][0], c[0][2] = -c[0][2], c[2][0] = -c[2][0];
  return c;
}

/// J C J^T.
Matrix3 carried(const Matrix3& J, const Matrix3& c) {
  Matrix3 half{}, out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) half[i][j] += J[i][k] * c[k][j];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) out[i][j] += half[i][k] * J[j][k];
  return out;
}

Residual residual_of(const PairMotion& pair, const Pose& odometry, const Pose& X, double drive, double turn) {
  const Pose base = compose(compose(X, pair.step), inverse(X));
  const SinCos64 half = portable_sincos64(0.5 * base.theta_rad), yaw = portable_sincos64(X.theta_rad);
  const SinCos64 whole = portable_sincos64(base.theta_rad);
  const double dx = odometry.x_m - base.x_m, dy = odometry.y_m - base.y_m;
  Residual r{};
  r.error = {(half.cos * dx + half.sin * dy) / drive, (half.cos * dy - half.sin * dx) / drive,
             wrap64(odometry.theta_rad - base.theta_rad) / turn};
  // Of the base's step by the sensor's, turned to the heading half-way.
  const double lever_x = whole.sin * X.x_m + whole.cos * X.y_m;
  const double lever_y = whole.sin * X.y_m - whole.cos * X.x_m;
  const Matrix3 J{
      {{(half.cos * yaw.cos + half.sin * yaw.sin) / drive, (half.sin * yaw.cos - half.cos * yaw.sin) / drive,
        (half.cos * lever_x + half.sin * lever_y) / drive},
       {(half.cos * yaw.sin - half.sin * yaw.cos) / drive, (half.cos * yaw.cos + half.sin * yaw.sin) / drive,
        (half.cos * lever_y - half.sin * lever_x) / drive},
       {0.0, 0.0, 1.0 / turn}}};
  r.covariance = carried(J, pair.covariance);
  r.ways = distance_m({}, base) / ScanMotions::kKeyStep_m;
  r.turns = std::fabs(base.theta_rad) / ScanMotions::kKeyTurn_rad;
  return r;
}

/// A step that is hardly any says nothing of what it would be multiplied by: its noise would, and as that is
/// in the error, too, it would make the factor small.
bool tells_of(std::size_t unknown, const Pose& step) {
  constexpr double kLeast_m = 0.25 * ScanMotions::kKeyStep_m, kLeast_rad = 0.25 * ScanMotions::kKeyTurn_rad;
  if (unknown == kDrive || unknown == kSide || unknown == kDrift) return distance_m({}, step) >= kLeast_m;
  if (unknown == kTurn) return std::fabs(step.theta_rad) >= kLeast_rad;
  return true;
}

}  // namespace

std::vector<PairMotion> pair_motions(const LidarMotions& lidar, bool upside_down) {
  std::vector<PairMotion> pairs;
  for (const ScanMotion& m : lidar.motions) {
    if (!m.usable) continue;
    const Pose step = upside_down ? mirrored(m.match.step) : m.match.step;
    pairs.push_back({lidar.keys[m.from].time_s, lidar.keys[m.from + 1].time_s, step,
                     upside_down ? mirrored_covariance(m.match.covariance) : m.match.covariance});
  }
  return pairs;
}

std::vector<Residual> residuals_at(const std::vector<PairMotion>& pairs, OdometryPath& path,
                                   const Unknowns& at, bool omni) {
  const OdometryScales scales = scales_at(at, omni);
  path.set_scales(scales);
  const Pose X{at[kX], at[kY], at[kYaw]};
  std::vector<Residual> residuals;
  for (const PairMotion& pair : pairs) {
    const Pose odometry = relative(path.at(pair.to_s + at[kDelay]), path.at(pair.from_s + at[kDelay]));
    residuals.push_back(residual_of(pair, odometry, X, scales.drive, scales.turn));
  }
  return residuals;
}

Derivatives derivatives_at(const std::vector<PairMotion>& pairs, OdometryPath& path, const Unknowns& at,
                           const std::array<bool, 8>& free) {
  const Unknowns width{1e-4, 1e-4, 1e-5, 1e-5, 1e-5, std::max(0.05, path.period_s()), 1e-5, 1e-5};
  const Pose X{at[kX], at[kY], at[kYaw]}, back = inverse(X);
  std::vector<Pose> steps;
  for (const PairMotion& pair : pairs) steps.push_back(compose(compose(X, pair.step), back));
  Derivatives derivatives;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!free[i]) continue;
    Unknowns above = at, below = at;
    above[i] += width[i], below[i] -= width[i];
    const std::vector<Residual> more = residuals_at(pairs, path, above, free[kSide]);
    const std::vector<Residual> less = residuals_at(pairs, path, below, free[kSide]);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      std::array<double, 3> d{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (tells_of(i, steps[k])) d[axis] = (more[k].error[axis] - less[k].error[axis]) / (2.0 * width[i]);
      derivatives[i].push_back(d);
    }
  }
  return derivatives;
}

}  // namespace parloc
