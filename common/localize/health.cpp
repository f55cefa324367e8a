#include "common/localize/health.h"

#include "common/math/portable.h"

namespace parloc {
namespace {

constexpr double kMemory_s = 0.4;  // of the running mean

/// Logistic regression of "is right" on the evidence: docs/localize.md says on what, and how well it
/// fits.
constexpr double kOffset = -3.0, kSlope = 6.0;

constexpr double kLost = 0.05, kFound = 0.5;  // apart, so that it does not flicker
constexpr double kOnePlace = 0.8;             // share of the weight that is one place

}  // namespace

const char* name_of(HealthState state) {
  return state == HealthState::tracking ? "tracking" : state == HealthState::ambiguous ? "ambiguous" : "lost";
}

void HealthMonitor::reset() {
  *this = {};
}

Health HealthMonitor::update(double stamp_s, double evidence, double share) {
  const double since_s = stamp_s - last_s_;
  const bool follows = seen_ && since_s > 0.0;  // stamps may run backwards
  const double keep = follows ? static_cast<double>(portable_exp(static_cast<float>(-since_s / kMemory_s)))
                      : seen_ ? 0.5
                              : 0.0;
  evidence_ = keep * evidence_ + (1.0 - keep) * evidence;
  seen_ = true;
  last_s_ = stamp_s;

  const double logit = kOffset + kSlope * evidence_;
  const double fits = 1.0 / (1.0 + static_cast<double>(portable_exp(static_cast<float>(-logit))));
  lost_ = lost_ ? fits < kFound : fits < kLost;
  const HealthState state = lost_               ? HealthState::lost
                            : share < kOnePlace ? HealthState::ambiguous
                                                : HealthState::tracking;
  return {fits * share, evidence_, state};
}

}  // namespace parloc
