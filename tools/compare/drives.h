// The logs that filters are compared on: simulated anew for every seed, or one recorded log.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/eval/trial.h"
#include "common/io/log_choice.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"
#include "tools/program/run_items.h"

namespace parloc::tools::compare {

/// The robot is carried along its path while its odometry notices nothing.
struct Kidnapping {
  double after_s = 0.0, until_s = 0.0;  ///< From the first scan: between these, by the seed.
  double distance_m = 0.0;              ///< Straight, from where it was.
};

struct DrivePlan {
  double duration_s = 0.0;  ///< Of every log, from its first scan with a true pose; 0: all of it.
  std::optional<Kidnapping> kidnapping;
};

/// The scenario's own drive, with another seed each.
/// From the first scan with a true pose on. Throws Error{input} if the robot never gets far enough to be
/// kidnapped.
LogSource simulated_drives(const DrivePlan& plan, const Scenario& scenario, const GridMap& map,
                           const std::string& name);
/// The same log for every seed. Throws Error{input} as the readers, for a log without a scan, and for a truth
/// of another time.
LogSource recorded_drives(const DrivePlan& plan, const std::string& log, const LogChoice& choice,
                          const std::string& truth);

/// When it happens in the drive of a seed, from the first scan. Seeds in a row spread evenly.
double kidnapped_after_s(const Kidnapping& kidnapping, std::uint64_t seed);
/// Leaves out what lies between: a piece of the log in which the robot gets that far, and its odometry.
/// Throws Error{input} if it never does.
void kidnap(TrialLog& log, double after_s, double distance_m);

}  // namespace parloc::tools::compare
