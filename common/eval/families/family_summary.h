// What the drives of a family say together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/eval/calibration.h"
#include "common/eval/families/drive_score.h"
#include "common/eval/result_stream.h"
#include "common/eval/trial_summary.h"

namespace parloc {

/// Of all drives with the closed loop, or all with the bare filter.
struct RunsSummary {
  Rate nearly_all_within;  ///< Drives with 99 % of the scans within 0.5 m.
  Rate all_within;         ///< With all of them.
  double within = 0.0;     ///< Share of all scans.
  Spread rmse_m;           ///< Over drives, as far as they are finite.
  double largest_m = 0.0;
  std::array<double, 3> by_state{};  ///< Share of all scans, by HealthState.
  double sure_wrong = 0.0;           ///< Share of the time driven.
  Rate sure_wrong_1s;                ///< Drives with 1 s of it in a row or more.
  double late_sure_wrong = 0.0;      ///< Share of the scans after the first 10 s of each drive.
  MeanInterval nees;                 ///< Of the drives' means; 3 is right.
  double nees_median = 0.0;          ///< Likewise: one drive that is far off does not hide the others.
  /// Root mean square over the drives, at their last scan, along the map's x axis, as a corridor lies: what
  /// the error is, and what the filter says.
  double x_error_m = 0.0, sigma_x_m = 0.0;
  Rate localized_5s;               ///< Within 5 s of the start, or of a kidnapping.
  Rate noticed_2s;                 ///< A kidnapping.
  double searches = 0.0;           ///< Per drive.
  Calibration calibration;         ///< Of the probability, over all scans.
  double calibration_error = 0.0;  ///< Expected, over its ten bins.
};

struct FamilySummary {
  std::string family;
  std::size_t drives = 0, scans = 0;
  double driven_s = 0.0;
  Rate kept;  ///< Of the drives where the bare filter stays within 0.5 m: the loop makes it no worse.
  std::vector<std::uint64_t> failed;  ///< Seeds of those of them where it does.
  RunsSummary closed, bare;
};

/// Of all drives, as one named "all", and of each family, in the order of their first drives.
struct FamilySummaries {
  FamilySummary all;
  std::vector<FamilySummary> families;
};
/// Goes through the drives once, and keeps some 60 bytes of each. They are to be in the order of their
/// numbers: sums depend on it in their last bits.
FamilySummaries summarise_families(const ResultStream<DriveResult>& drives);

}  // namespace parloc
