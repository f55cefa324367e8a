// All filters on all logs, each against the truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/eval/metrics.h"
#include "common/eval/result_stream.h"
#include "common/eval/trial.h"
#include "common/filter/pose_filter.h"
#include "common/map/grid_map.h"
#include "tools/compare/drives.h"
#include "tools/compare/entry.h"

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

struct Request {
  std::vector<Entry> entries;
  StartPlan start;
  std::uint64_t first_seed = 1;
  std::size_t seeds = 1;
  std::vector<std::size_t> items;  ///< Which of them: item k has the seed first_seed + k.
  int jobs = 1;  ///< Seeds at once: with more than one, times are those of filters that disturb each other.
  std::function<bool()> stop;  ///< Asked often; may be empty.
  /// Told now and then, on the caller's thread; may be empty.
  std::function<void(double fraction, std::size_t finished)> progress;
};

/// All filters on the log of one seed.
struct SeedRuns {
  std::vector<std::optional<FilterRun>> runs;  ///< By entry; what `stop` cut off is not there.
  std::vector<std::string> backends;   ///< As each entry's filter calls its own; "" if it did not run.
  std::size_t hits = 0, unmapped = 0;  ///< Of the simulated beams.

  bool whole() const;
};
/// Told of each seed, by any thread.
using KeepSeed = std::function<void(std::size_t item, double took_s, SeedRuns runs)>;

/// The first error of any run, or of `keep`, ends the work and is thrown.
void run_all(const Request& request, const LogSource& source, const GridMap& map, const KeepSeed& keep);

struct Outcome {
  std::vector<std::vector<FilterRun>> runs;  ///< By entry, then in the order of seeds.
  std::vector<std::string> backends;         ///< By entry; "" if it never ran.
  std::size_t finished = 0;                  ///< Runs, of entries times seeds.
  std::size_t hits = 0, unmapped = 0;        ///< Summed over the seeds.
};
/// Of seeds in their order.
Outcome outcome_of(std::size_t entries, const ResultStream<SeedRuns>& seeds);

}  // namespace parloc::tools::compare
