#include "common/localize/missing_returns.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kForgets = 0.02;  ///< Per independent scan: a LiDAR may get dirty on the way.
/// Two beams hit the same wall if they are so close together.
constexpr double kSameWall_rad = 0.2, kSameWallShare = 0.15, kSameWall_m = 0.1;

}  // namespace

void MissingReturns::add(const BeamTable& beams, double novelty) {
  around_.clear();
  for (std::size_t m = 0; m < beams.count; ++m) {
    const auto x = static_cast<double>(beams.direction_x[m]), y = static_cast<double>(beams.direction_y[m]);
    around_.push_back({portable_atan2_64(y, x), static_cast<double>(beams.range_m[m]), m < beams.hits});
  }
  std::stable_sort(around_.begin(), around_.end(),
                   [](const Beam& a, const Beam& b) { return a.bearing_rad < b.bearing_rad; });
  double lost = 0.0, asked = 0.0;
  for (std::size_t k = 1; k + 1 < around_.size(); ++k) {
    const Beam &left = around_[k - 1], &right = around_[k + 1];
    if (!left.hit || !right.hit || right.bearing_rad - left.bearing_rad > kSameWall_rad) continue;
    if (std::fabs(left.range_m - right.range_m) >
        kSameWall_m + kSameWallShare * std::min(left.range_m, right.range_m))
      continue;
    asked += 1.0;
    lost += around_[k].hit ? 0.0 : 1.0;
  }
  const double keep = 1.0 - kForgets * novelty;
  lost_ = keep * lost_ + novelty * lost;
  asked_ = keep * asked_ + novelty * asked;
}

}  // namespace parloc
