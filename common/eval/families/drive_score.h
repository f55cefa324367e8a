// One drive driven twice, with the closed loop and with the bare filter, and whether the loop made it worse.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/eval/run_trial.h"
#include "common/localize/localizer.h"

namespace parloc {

/// How a run went, over all scans whose true pose is known.
struct RunScore {
  std::size_t samples = 0;
  double rmse_m = 0.0, largest_m = 0.0;  ///< Infinite where no pose is right.
  double largest_rad = 0.0;
  double within = 0.0;                        ///< Share of the scans within 0.5 m.
  std::array<double, 3> by_state{};           ///< Share of the scans by HealthState.
  double sure_wrong_s = 0.0;                  ///< `tracking` while further than 0.5 m or 10 degrees.
  double longest_sure_wrong_s = 0.0;          ///< In a row.
  std::size_t late = 0, late_sure_wrong = 0;  ///< Scans after the first 10 s; those of them that are so.
  double nees_mean = 0.0;                     ///< Since it was localized; NaN if it never was.
  double last_x_error_m = 0.0, last_sigma_x_m = 0.0;
  std::size_t searches = 0;
  std::optional<double> localized_after_s, noticed_after_s;
};
RunScore score_run(const TrialResult& trial);

/// What must hold where the bare filter does its work: within 0.5 m all the time.
struct Comparison {
  bool applies = false;
  bool kept =
      false;  ///< The loop's RMSE is at most 1.1 times the bare filter's, its largest error 0.1 m more.
};
Comparison compare_runs(const RunScore& closed, const RunScore& bare);

/// A drive with both runs.
struct DriveResult {
  std::string family;
  std::string place;  ///< What was driven through, for people; a file of a recorded drive.
  std::uint64_t seed = 0;
  std::vector<std::pair<std::string, double>> parameters;  ///< As drawn.
  std::size_t events = 0;                                  ///< Of the odometry: slips, pushes, resets.
  double driven_s = 0.0;
  TrialResult closed, bare;
  RunScore closed_score, bare_score;
  Comparison comparison;
};

}  // namespace parloc
