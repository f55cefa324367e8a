#include "common/localize/scan_novelty.h"

#include <algorithm>

namespace parloc {
namespace {

constexpr double kNewAfterShare = 0.05, kNewAfterLeast_m = 0.1, kNewAfterMost_m = 1.0;
constexpr double kNewAfter_rad = 0.2, kNewAfter_s = 2.0;

double mean_range_m(const BeamTable& beams) {
  double sum = 0.0;
  for (std::size_t m = 0; m < beams.hits; ++m) sum += static_cast<double>(beams.range_m[m]);
  return beams.hits > 0 ? sum / static_cast<double>(beams.hits) : 0.0;
}

}  // namespace

double ScanNovelty::add(const Pose& odometry, double elapsed_s, const BeamTable& beams) {
  double share = 1.0;
  if (before_) {
    const double new_after_m =
        std::clamp(kNewAfterShare * mean_range_m(beams), kNewAfterLeast_m, kNewAfterMost_m);
    share = std::min(1.0, distance_m(*before_, odometry) / new_after_m +
                              turn_rad(*before_, odometry) / kNewAfter_rad + elapsed_s / kNewAfter_s);
  }
  before_ = odometry;
  return share;
}

}  // namespace parloc
