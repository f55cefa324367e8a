// One trial of a localizer: a drive that it has to find itself in, and how it did.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/eval/calibration.h"
#include "common/filter/particle_filter.h"
#include "common/filter/pose/pose_guess.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/localize/health.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"
#include "common/simulator/wander.h"

namespace parloc {

/// What a trial asks for.
enum class TrialTask {
  global,  ///< The start is not given.
  kidnap,  ///< The start is given; after a while the robot is somewhere else and the odometry does not know.
  track,   ///< The start is given.
};

struct TrialPlan {
  TrialTask task = TrialTask::global;
  double duration_s = 13.0;  ///< Of the drive; of each of the two with `kidnap`.
  double speed_mps = 0.5;
  double turn_rate_rad_s = 0.8;
  double near_m = 0.5, near_rad = 0.17453292519943295;  ///< Closer than this is right.
  double hold_s = 10.0;                                 ///< Localized: right, and for so long from there.
  double grace_s = 2.0;  ///< After a kidnapping, in which it need not have noticed yet.
};

/// What the robot records, and where it truly is.
struct TrialLog {
  std::vector<LogRecord> records;      ///< Scans and odometry in time.
  Trajectory truth;                    ///< At each scan.
  double kidnapped_s = 0.0;            ///< Stamp of the first scan at the new place; with `kidnap` only.
  std::size_t hits = 0, unmapped = 0;  ///< Simulated: beams that hit, and those of them that hit clutter.
  std::optional<PoseGuess> start{};    ///< What is said where a start is given; else about the true pose.
  bool elsewhere = false;              ///< The place is not on the localizer's map: no pose there is right.
};

/// Simulates drives that differ in path, seed and clutter. From the second on the robot was put down
/// elsewhere: its odometry and its clock go on. Each ends after `duration_s` at most.
TrialLog simulate_drives(std::vector<Scenario> drives, const GridMap& map, double duration_s);

/// Drives at random over `area` (WanderArea) and simulates what the scenario's LiDARs and wheels make of it;
/// the scenario's own path, map and seed are not used, but that boxes stand as dense as along that path.
/// Equal seeds give equal trials on every machine.
TrialLog simulate_trial(const TrialPlan& plan, const Scenario& scenario, const GridMap& map,
                        const WanderArea& area, std::uint64_t seed);

/// What the localizer said at a scan, and how far off it was.
struct TrialSample {
  double stamp_s = 0.0;
  double position_error_m = 0.0, heading_error_rad = 0.0;  ///< Infinite where no pose is right.
  double x_error_m = 0.0, sigma_x_m = 0.0;  ///< Along the map's x axis: signed, and as the filter has it.
  double probability = 0.0;                 ///< Of being right, as it says.
  double evidence = 0.0;                    ///< What the scans say for it [nat per beam] (HealthMonitor).
  double log_odds = 0.0;                    ///< Likewise [nat].
  double share = 0.0;                       ///< Of the weight, around the estimate.
  HealthState state = HealthState::lost;
  bool searched = false;  ///< The whole map was searched in this step.
  double nees = 0.0;
  double particles = 0.0;
  double step_ms = 0.0;  ///< RayWall time.
};

struct TrialOutcome {
  std::optional<double> localized_after_s;  ///< From the start, or from the kidnapping.
  std::optional<double> noticed_after_s;    ///< kidnap: until it no longer says `tracking`.
  bool tracked_before = false;              ///< kidnap: right and `tracking` at the last scan before it.
  std::size_t samples = 0, right = 0;
  std::size_t confident_wrong = 0;  ///< Samples with `tracking` that are wrong, but in the time of grace.
  double confident_wrong_s = 0.0;   ///< The longest stretch of these.
  std::size_t false_lost = 0;       ///< Times that it turned to `lost` while right.
  /// A sample stands for the time until the next one. Of the wrong time: that in which it says `tracking`.
  double right_s = 0.0, wrong_s = 0.0, missed_lost_s = 0.0;
  /// Over the samples since it was localized.
  double squared_error_m2 = 0.0, nees_sum = 0.0;
  std::size_t since_localized = 0, wrong_since = 0;
  std::size_t nees_count = 0;  ///< Those that have one.
};

/// Whether the estimate is close enough to the truth. Not if an error is not finite.
bool is_right(const TrialPlan& plan, const TrialSample& sample);

TrialOutcome judge_trial(const TrialPlan& plan, const std::vector<TrialSample>& samples, double since_s);

}  // namespace parloc
