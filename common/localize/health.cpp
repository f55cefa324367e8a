#include "common/localize/health.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// What the evidence of one scan says of its place [nat]: linear about where right and wrong places are as
/// common, and never more than a few nat, since a scan may be bad by itself. They are as common at a share of
/// what is attainable there that is so far below what is typical of the drive, but within bounds: where a
/// scan can tell little, little is said.
constexpr double kBelowTypical = 0.33, kEvenLeast = 0.25, kEvenMost = 0.5;
constexpr double kPerNat = 6.0, kMostPerScan = 4.0;
/// Of the running mean of good evidence, per independent scan.
constexpr double kTypicalRate = 0.02;
constexpr double kAccepted = 1.0;  ///< [nat]
/// What a place can earn and lose: it takes so many bad scans to doubt a good place, and good ones to trust a
/// bad.
constexpr double kMostFor = 7.0, kMostAgainst = -6.0;
/// The running mean of the evidence, for people.
constexpr double kSmoothing = 0.5;

/// Logistic regression of "is right" on the log-odds: docs/localize.md says on what, and how well it fits.
constexpr double kOffset = 0.0, kSlope = 1.0;

constexpr double kLost = 0.05, kFound = 0.5;  // apart, so that it does not flicker
constexpr double kOnePlace = 0.8;             // share of the weight that is one place
constexpr double kCloseEnough = 0.5;          // of an estimate that says where the robot is

constexpr double kNear_m = 0.5, kNear_rad = 10.0 * kPi / 180.0;

/// That a normal deviate of this variance is no farther off.
double central_probability(double most, double variance) {
  if (!(variance > 0.0)) return variance == 0.0 ? 1.0 : 0.0;
  return 1.0 - static_cast<double>(portable_erfc(static_cast<float>(most / std::sqrt(2.0 * variance))));
}

}  // namespace

const char* name_of(HealthState state) {
  return state == HealthState::tracking ? "tracking" : state == HealthState::ambiguous ? "ambiguous" : "lost";
}

double probability_within(const Covariance& covariance) {
  const double* v = covariance.v;
  const double mean = 0.5 * (v[0] + v[4]), half = 0.5 * (v[0] - v[4]);
  const double apart = std::sqrt(half * half + v[1] * v[1]);
  return central_probability(kNear_m, mean + apart) *
         central_probability(kNear_m, std::max(mean - apart, 0.0)) * central_probability(kNear_rad, v[8]);
}

void HealthMonitor::reset(double log_odds) {
  *this = {};
  log_odds_ = log_odds;
}

void HealthMonitor::accept() {
  log_odds_ = std::max(log_odds_, kAccepted);
  typical_ = std::min(typical_, std::max(share_, kEvenLeast + kBelowTypical));
}

Health HealthMonitor::update(const ScanFit& fit) {
  const double part = seen_ ? kSmoothing * fit.novelty : 1.0;
  const double reached = fit.attainable > 0.0 ? std::clamp(fit.evidence / fit.attainable, -1.0, 1.0) : 0.0;
  evidence_ += part * (fit.evidence - evidence_);
  share_ += part * (reached - share_);
  seen_ = true;
  const double even = std::clamp(typical_ - kBelowTypical, kEvenLeast, kEvenMost);
  const double excess = fit.evidence - even * fit.attainable;
  const double says = std::clamp(kPerNat * excess, -kMostPerScan, kMostPerScan);
  if (excess > 0.0) typical_ += kTypicalRate * fit.novelty * (reached - typical_);
  log_odds_ = std::clamp(log_odds_ + fit.novelty * says, kMostAgainst, kMostFor);

  const double logit = kOffset + kSlope * log_odds_;
  const double fits = 1.0 / (1.0 + static_cast<double>(portable_exp(static_cast<float>(-logit))));
  lost_ = lost_ ? fits < kFound : fits < kLost;
  const bool one_place = fit.share >= kOnePlace && fit.within >= kCloseEnough;
  const HealthState state = lost_       ? HealthState::lost
                            : one_place ? HealthState::tracking
                                        : HealthState::ambiguous;
  return {fits * fit.share * fit.within, evidence_, log_odds_, state};
}

}  // namespace parloc
