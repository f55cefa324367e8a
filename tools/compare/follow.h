// One filter on one log, against the truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/eval/metrics.h"
#include "common/eval/trial.h"
#include "common/filter/pose_filter.h"

namespace parloc::tools::compare {

/// What the filters are told of the start, and how far off that is.
struct StartPlan {
  double sigma_xy_m = 0.1, sigma_theta_rad = 0.05;  ///< As published.
  double off_m = 0.0, off_rad = 0.0;
};

/// The start that filters are told: the truth, displaced by `off_m` in a direction that goes round the circle
/// with the seed, and turned by `off_rad`, left for odd seeds and right for even ones.
Pose told_start(const StartPlan& plan, const Pose& truth, std::uint64_t seed);

/// A run that is farther off than this at its end has lost its robot.
inline constexpr double kLost_m = 0.5;

struct FilterRun {
  std::uint64_t seed = 0;
  TrackErrors errors;
  double nees = 0.0;     ///< Mean over the scans; 3 is right.
  double final_m = 0.0;  ///< Position error at the last scan.
  /// From the first scan until it was within kLost_m for good, or farther off for good: one of them is there.
  std::optional<double> found_s, lost_s;
  double away = 0.0;           ///< Share of the scans at which it was farther off than kLost_m.
  double particles = 0.0;      ///< Mean.
  std::size_t scans = 0;       ///< Taken in or not.
  std::size_t skipped = 0;     ///< Scans that changed nothing.
  double driven_s = 0.0;       ///< From the first scan to the last.
  double working_s = 0.0;      ///< RayWall time of all steps but the first, which warms up.
  std::vector<double> step_s;  ///< Of each of them that took its scan in.

  bool lost() const { return !(final_m <= kLost_m); }
};

/// From the log's first scan, whose true pose must be known, to its end. `keep_going`, if given, is asked
/// after every scan; false ends the run, which then has no result.
std::optional<FilterRun> follow(PoseFilter& filter, const TrialLog& log, const StartPlan& start,
                                std::uint64_t seed, const std::function<bool()>& keep_going = {});

}  // namespace parloc::tools::compare
