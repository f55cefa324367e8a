#include "common/filter/pose/gaussian.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "common/error.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// What rounding leaves of numbers that are equal, as a share of their scale.
constexpr double kCovarianceRounding = 1e-9;

void expect_covariance(bool good, const char* what) {
  if (!good) throw Error(ErrorKind::input, std::string("covariance of a pose: expected ") + what);
}

/// A column of the root: its pivot, and the entries below it, which are to be 0 where the pivot is.
double root_pivot(double squared, double scale) {
  expect_covariance(squared >= -kCovarianceRounding * scale, "one that is positive semidefinite");
  return squared > 0.0 ? std::sqrt(squared) : 0.0;
}
double below_pivot(double product, double pivot, double scale) {
  if (pivot > 0.0) return product / pivot;
  expect_covariance(std::fabs(product) <= std::sqrt(kCovarianceRounding) * scale,
                    "one that is positive semidefinite");
  return 0.0;
}

}  // namespace

CovarianceRoot root_of(const Covariance& c) {
  expect_covariance(std::all_of(std::begin(c.v), std::end(c.v), [](double v) { return std::isfinite(v); }),
                    "finite numbers");
  const double x = c.v[0], y = c.v[4], t = c.v[8];
  expect_covariance(x >= 0.0 && y >= 0.0 && t >= 0.0, "variances that are not negative");
  const double scale_xy = std::sqrt(x * y), scale_xt = std::sqrt(x * t), scale_yt = std::sqrt(y * t);
  const auto same = [](double a, double b, double scale) {
    return std::fabs(a - b) <= kCovarianceRounding * std::max({scale, std::fabs(a), std::fabs(b)});
  };
  expect_covariance(
      same(c.v[1], c.v[3], scale_xy) && same(c.v[2], c.v[6], scale_xt) && same(c.v[5], c.v[7], scale_yt),
      "one that is symmetric");
  CovarianceRoot root;
  root.xx = root_pivot(x, x);
  root.yx = below_pivot(c.v[3], root.xx, scale_xy);
  root.tx = below_pivot(c.v[6], root.xx, scale_xt);
  root.yy = root_pivot(y - root.yx * root.yx, y);
  root.ty = below_pivot(c.v[7] - root.tx * root.yx, root.yy, scale_yt);
  root.tt = root_pivot(t - root.tx * root.tx - root.ty * root.ty, t);
  return root;
}

PoseEstimate moved(const PoseEstimate& from, const Pose& motion, const MotionStep& step) {
  PoseEstimate to = from;
  to.mean = compose(from.mean, motion);
  const double dx = to.mean.x_m - from.mean.x_m, dy = to.mean.y_m - from.mean.y_m;
  // J C J^T with J = [1 0 -dy; 0 1 dx; 0 0 1]: an error of the heading swings the way around.
  const double *c = from.covariance.v, tt = c[8];
  double xx = c[0] - 2.0 * dy * c[2] + dy * dy * tt, yy = c[4] + 2.0 * dx * c[5] + dx * dx * tt;
  double xy = c[1] + dx * c[2] - dy * c[5] - dx * dy * tt, xt = c[2] - dy * tt, yt = c[5] + dx * tt;
  double theta = tt;
  const auto add = [&](double x, double y, double t, double sigma) {  // noise along a direction of (x, y, t)
    const double v = sigma * sigma;
    xx += v * x * x, xy += v * x * y, yy += v * y * y, xt += v * x * t, yt += v * y * t, theta += v * t * t;
  };
  const double length = static_cast<double>(step.trans);
  const SinCos64 way = portable_sincos64(from.mean.theta_rad + static_cast<double>(step.rot1));
  add(-length * way.sin, length * way.cos, 1.0, static_cast<double>(step.sigma_rot1));
  add(way.cos, way.sin, 0.0, static_cast<double>(step.sigma_trans));
  add(0.0, 0.0, 1.0, static_cast<double>(step.sigma_rot2));
  add(way.sin, -way.cos, 0.0, static_cast<double>(step.sigma_strafe));
  const auto widen = [&](double sigma_xy, double sigma_theta, double share) {
    xx += share * sigma_xy * sigma_xy, yy += share * sigma_xy * sigma_xy;
    theta += share * sigma_theta * sigma_theta;
  };
  widen(static_cast<double>(step.spread_xy), static_cast<double>(step.spread_theta), 1.0);
  if (step.slip_every > 0)
    widen(static_cast<double>(step.slip_xy), static_cast<double>(step.slip_theta),
          1.0 / static_cast<double>(step.slip_every));
  to.covariance = {{xx, xy, xt, xy, yy, yt, xt, yt, theta}};
  return to;
}

}  // namespace parloc
