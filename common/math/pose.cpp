#include "common/math/pose.h"

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

}  // namespace parloc
