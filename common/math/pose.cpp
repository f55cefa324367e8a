#include "common/math/pose.h"

#include <cmath>

#include "common/math/portable64.h"

namespace parloc {

Pose compose(const Pose& a, const Pose& b) {
  const SinCos64 r = portable_sincos64(a.theta_rad);
  return {a.x_m + r.cos * b.x_m - r.sin * b.y_m, a.y_m + r.sin * b.x_m + r.cos * b.y_m,
          wrap64(a.theta_rad + b.theta_rad)};
}

Pose relative(const Pose& a, const Pose& b) {
  const SinCos64 r = portable_sincos64(b.theta_rad);
  const double dx = a.x_m - b.x_m;
  const double dy = a.y_m - b.y_m;
  return {r.cos * dx + r.sin * dy, -r.sin * dx + r.cos * dy, wrap64(a.theta_rad - b.theta_rad)};
}

Pose inverse(const Pose& a) {
  return relative(Pose{}, a);
}

bool is_finite(const Pose& pose) {
  return __builtin_isfinite(pose.x_m) && __builtin_isfinite(pose.y_m) && __builtin_isfinite(pose.theta_rad);
}

double distance_m(const Pose& a, const Pose& b) {
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  return std::sqrt(dx * dx + dy * dy);
}

double turn_rad(const Pose& a, const Pose& b) {
  return std::fabs(wrap64(b.theta_rad - a.theta_rad));
}

Pose blend(const Pose& a, const Pose& b, double part) {
  return {a.x_m + part * (b.x_m - a.x_m), a.y_m + part * (b.y_m - a.y_m),
          wrap64(a.theta_rad + part * wrap64(b.theta_rad - a.theta_rad))};
}

namespace {

/// Means of cos and sin over the angles from 0 to a: a unit way along an arc that turns by a ends there.
SinCos64 mean_direction(double a) {
  // Below it the series is exact to the last bit; above it nothing cancels.
  constexpr double small_rad = 1e-2;
  if (a > -small_rad && a < small_rad) {
    const double z = a * a;
    return {a * (0.5 - z * (1.0 / 24.0 - z / 720.0)), 1.0 - z * (1.0 / 6.0 - z / 120.0)};
  }
  const SinCos64 half = portable_sincos64(0.5 * a);
  return {2.0 * half.sin * half.sin / a, 2.0 * half.sin * half.cos / a};
}

}  // namespace

Pose along_arc(const Pose& step, double part) {
  // The velocity, in the moving body's frame, that makes the whole step in one unit of time.
  const SinCos64 whole = mean_direction(step.theta_rad);
  const double scale = 1.0 / (whole.cos * whole.cos + whole.sin * whole.sin);
  const double forward_m = (whole.cos * step.x_m + whole.sin * step.y_m) * scale;
  const double left_m = (whole.cos * step.y_m - whole.sin * step.x_m) * scale;
  const SinCos64 some = mean_direction(part * step.theta_rad);
  return {part * (some.cos * forward_m - some.sin * left_m),
          part * (some.sin * forward_m + some.cos * left_m), wrap64(part * step.theta_rad)};
}

ArcMotion arc_motion(const Pose& step) {
  const SinCos64 mean = mean_direction(step.theta_rad);
  const double scale = 1.0 / (mean.cos * mean.cos + mean.sin * mean.sin);
  return {(mean.cos * step.x_m + mean.sin * step.y_m) * scale,
          (mean.cos * step.y_m - mean.sin * step.x_m) * scale, step.theta_rad};
}

Pose arc_end(const ArcMotion& m) {
  const SinCos64 mean = mean_direction(m.turn_rad);
  return {mean.cos * m.ahead_m - mean.sin * m.side_m, mean.sin * m.ahead_m + mean.cos * m.side_m,
          wrap64(m.turn_rad)};
}

}  // namespace parloc
