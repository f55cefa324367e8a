// Localizes a log: one step per scan, and everything that is worth knowing about it afterwards.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/eval/consistency.h"
#include "common/filter/particle_filter.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/localize/modes.h"
#include "common/map/grid_map.h"
#include "tools/program/scan_times.h"
#include "tools/report/report.h"
#include "tools/run/pose_file.h"
#include "tools/run/start_pose.h"

namespace parloc::tools {

/// A step with what it was made of. Valid as long as the call that it is handed to.
struct StepView {
  const ScanAnswer& answer;
  const LogRecord& record;
  const ParticleFilter& filter;  ///< After the step.
};

struct LocalizeRequest {
  Config config;
  std::optional<StartPose> start;  ///< Empty: from `truth`.
  Trajectory truth;                ///< May be empty. Used for the start only.
  std::string log_name;            ///< For messages.
  bool odometry_only = false;      ///< Predict, never weigh: how the particles spread without the LiDAR.
  bool strict = false;             ///< What would be counted as a warning is an Error{input}.
  std::function<void(double fraction, std::size_t scans)>
      progress;                                     ///< Called after every scan; may be empty.
  std::function<void(const ScanAnswer&)> answered;  ///< Likewise, with what is said of it.
  std::function<void(const StepView&)> stepped;     ///< Likewise.
  std::function<void(const LogWarnings&)> read;     ///< Likewise, of every record: for notes as they come.
  std::function<bool()> stop;  ///< Asked before every scan; may be empty. True ends the run early.
};

struct Localization {
  Trajectory trajectory;          ///< One row per scan, in file order: the estimate at the scan.
  Trajectory odometry;            ///< Dead reckoning from the start pose; empty if it is not one.
  std::vector<StepRecord> steps;  ///< One per scan.
  std::vector<StampedCovariance> covariances;  ///< Likewise: of the estimate.
  std::vector<Snapshot> snapshots;  ///< 7 to 13 over the whole run (fewer scans: all), the last one included.
  std::size_t scans = 0;            ///< Read from the log.
  std::size_t filter_steps = 0;
  std::vector<Mode> modes;     ///< At the end, if ambiguous then: the places that are possible.
  std::size_t lost_steps = 0;  ///< Every particle had weight zero.
  std::size_t odometry_jumps = 0;
  BeamCounts beams;              ///< Of all LiDARs.
  std::vector<LidarUse> lidars;  ///< Of each, in the order in which they came.
  LogWarnings warnings;
  ScanTimes times;
  Config config;
  std::string backend;
  std::string digest;
  double wall_s = 0.0;  ///< From the first scan's step to the end, reading the log included, the map not.
  double log_s = 0.0;   ///< Between the first and the last stamp in time.
  bool odometry_only = false;
  bool interrupted = false;  ///< `stop` said so before the end; perhaps before the first scan.

  double real_time_factor() const { return wall_s > 0.0 ? log_s / wall_s : 0.0; }
};

/// Runs the closed loop over the whole log, or the bare filter with `odometry_only` or without
/// localize.health: then no step has a health. With `odometry_only` the estimate is the mean: without weights
/// no cluster is better than another. Deterministic but for the times measured. Throws Error{input} for a log
/// without a scan, a start that is not finite or not on the map, no start at all, and with `strict` at the
/// first warning; Error{config} and Error{backend} as Localizer.
Localization localize_log(const GridMap& map, LogReader& log, const LocalizeRequest& request);

/// Why beams are dropped, in the words of JSON, of --strict and of the summary.
struct RejectReason {
  const char *key, *strict, *summary;
  std::size_t BeamCounts::*count;
};
inline constexpr RejectReason kRejectReasons[] = {
    {"nan", "NaN", "NaN", &BeamCounts::nan},
    {"infinite", "infinite", "-infinity", &BeamCounts::infinite},
    {"negative", "negative", "negative", &BeamCounts::negative},
    {"zero", "zero", "zero", &BeamCounts::zero},
    {"below_min", "too short", "below the minimum", &BeamCounts::below_min}};

/// One line on the LiDARs that are configured but that the log does not have; empty if there are none.
std::string unused_lidars(const StepConfig& config, const std::vector<LidarUse>& used);

/// Median and p99 of the steps' wall times but the first, which pays for warming up; NaN without a second
/// step.
struct StepTimes {
  double median_ms, p99_ms;
};
StepTimes step_times(const std::vector<StepRecord>& steps);

/// Over the steps: how many particles were weighed, and which share was drawn from free space.
struct ParticleNumbers {
  double mean, min, max, injected_mean;
};
ParticleNumbers particle_numbers(const std::vector<StepRecord>& steps);

/// How sure a run was, from scan to scan and at its end.
struct RunHealth {
  std::size_t scans = 0, tracking = 0, ambiguous = 0, lost = 0;
  std::size_t searches = 0;
  std::vector<double> lost_s;  ///< Stamps at which it turned lost; a start anywhere does not count.
  Health last;
  std::vector<Mode> modes;  ///< At the end, while ambiguous.
};

/// Empty for a run that was not judged.
std::optional<RunHealth> run_health(const Localization& run);

/// "tracking 98.2 %, ambiguous 1.5 %, lost 0.3 % of the scans; searched 2 times"
std::string health_text(const RunHealth& health);

/// One line that says that the place at the end is not known; empty if it is, or if nobody judged.
std::string doubt_at_end(const Localization& run);

}  // namespace parloc::tools
