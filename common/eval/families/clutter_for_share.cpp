#include <algorithm>
#include <cmath>
#include <limits>

#include "common/eval/families/family_trial.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

constexpr int kMostBoxes = 300;
constexpr double kBoxesPerPerson = 5.0;  // that hide about as much

/// A few scans of the same drive: nothing but the rates and the beams is different.
Scenario sparse(const Scenario& scenario, double duration_s) {
  constexpr double kScans = 12.0, kTicksPerSecond = 200.0;
  constexpr int kMostBeams = 120;
  Scenario few = scenario;
  few.scan_rate_hz = few.odometry.rate_hz =
      kTicksPerSecond / std::max(1.0, std::floor(kTicksPerSecond * duration_s / kScans));
  if (few.lidar.beams > kMostBeams) {
    few.lidar.angle_step_rad *= static_cast<double>(few.lidar.beams) / kMostBeams;
    few.lidar.beams = kMostBeams;
  }
  return few;
}

}  // namespace

SimulatedClutter clutter_for_share(const Scenario& scenario, const GridMap& world, double duration_s,
                                   double wanted, double people_part) {
  Scenario few = sparse(scenario, duration_s);
  SimulatedClutter best = scenario.clutter;
  double best_off = std::numeric_limits<double>::infinity();
  for (int amount = 1; amount <= kMostBoxes; amount += std::max(1, amount / 10)) {
    few.clutter.people = static_cast<int>(std::lround(people_part * amount / kBoxesPerPerson));
    few.clutter.boxes = static_cast<int>(std::lround((1.0 - people_part) * amount));
    const SimulatedLog log = simulate(few, world);
    const double share = static_cast<double>(log.unmapped) / std::max(1.0, static_cast<double>(log.hits));
    if (std::fabs(share - wanted) < best_off) {
      best = few.clutter;
      best_off = std::fabs(share - wanted);
    }
    if (share >= wanted) break;
  }
  return best;
}

}  // namespace parloc
