// A drawn drive made into what a robot records, and what its localizer is told.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/eval/families/drawn_drive.h"
#include "common/eval/families/places.h"
#include "common/eval/trial.h"
#include "common/simulator/corrupt_odometry.h"

namespace parloc {

struct FamilyTrial {
  TrialPlan plan;
  TrialLog log;
  std::shared_ptr<const GridMap> map;   ///< What the localizer gets.
  std::vector<CorruptionEvent> events;  ///< What was done to the odometry.
};

/// Simulates the drive. The world is changed, never the map: shelves and doors of the place's map are
/// elsewhere in it, or it is larger or smaller (the truth is then in the map's coordinates). Equal drives
/// give equal trials on every machine. May be called from several threads. Throws Error{input} as Places.
FamilyTrial make_trial(const DrawnDrive& drive, const Places& places);

/// The clutter, of boxes beside the path and of people, that the share `wanted` of the hits is on, as nearly
/// as their whole numbers allow; found on twelve scans spread over the drive.
SimulatedClutter clutter_for_share(const Scenario& scenario, const GridMap& world, double duration_s,
                                   double wanted, double people_part);

}  // namespace parloc
