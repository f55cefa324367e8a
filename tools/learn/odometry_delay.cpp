#include "tools/learn/odometry_delay.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "common/eval/metrics.h"
#include "common/math/pose.h"

namespace parloc::tools {
namespace {

constexpr double kMost_s = 0.3, kStep_s = 0.01;
constexpr int kSteps = static_cast<int>(kMost_s / kStep_s + 0.5);  // to either side of 0
/// A parabola is laid through the residuals this far to either side of the best delay.
constexpr int kParabola = 5;
/// Turns are taken over at least this time: shorter ones are the noise of poses.
constexpr double kLeastTurn_s = 0.2;
/// The standard error is that of leaving out one part of the log after the other: neighbouring turns are made
/// of the same readings, and go wrong together.
constexpr std::size_t kParts = 10;
/// Of less time between readings, jitter makes any turn rate; over more, between readings or poses, a robot
/// turns here and back, and a straight line between them tells of no delay.
constexpr double kShortest_s = 0.02, kLongest_s = 0.6;

/// A turn by the odometry, between two readings.
struct Turn {
  double from_s, to_s, rate_rad_s;
};

/// Poses between scans are interpolated, which smooths their noise: least where a turn begins and ends at
/// scans, so that a delay would win by its phase alone. Turns begin at all phases, for every delay alike.
constexpr int kPhases = 4;
constexpr std::size_t kFewest = 20 * kPhases;

/// From each reading, and from parts of the way to the next, to one at least kLeastTurn_s later.
std::vector<Turn> turns_of(const Trajectory& odometry) {
  std::vector<double> stamps_s;
  for (const StampedPose& reading : odometry)
    if (stamps_s.empty() || reading.stamp_s >= stamps_s.back() + kShortest_s)
      stamps_s.push_back(reading.stamp_s);
  std::vector<double> ends_s;
  for (std::size_t k = 0; k + 1 < stamps_s.size(); ++k)
    for (int phase = 0; phase < kPhases; ++phase)
      ends_s.push_back(stamps_s[k] + (stamps_s[k + 1] - stamps_s[k]) * phase / kPhases);
  const std::vector<std::optional<Pose>> at = truth_at(odometry, ends_s, kLongest_s);
  std::vector<Turn> turns;
  for (std::size_t k = 0, to = 0; k < ends_s.size(); ++k) {
    to = std::max(to, k + kPhases);
    while (to < ends_s.size() && ends_s[to] - ends_s[k] < kLeastTurn_s) ++to;
    if (to >= ends_s.size()) break;
    const double time_s = ends_s[to] - ends_s[k];
    if (at[k] && at[to] && time_s <= kLongest_s)
      turns.push_back({ends_s[k], ends_s[to], relative(*at[to], *at[k]).theta_rad / time_s});
  }
  return turns;
}

/// Turn rates by the poses for a delay; NaN where there is no pose.
std::vector<double> true_rates(const std::vector<Turn>& turns, const Trajectory& poses, double delay_s) {
  std::vector<double> stamps_s;
  for (const Turn& turn : turns)
    stamps_s.insert(stamps_s.end(), {turn.from_s - delay_s, turn.to_s - delay_s});
  const std::vector<std::optional<Pose>> at = truth_at(poses, stamps_s, kLongest_s);
  std::vector<double> rates(turns.size(), std::nan(""));
  for (std::size_t k = 0; k < turns.size(); ++k)
    if (at[2 * k] && at[2 * k + 1])
      rates[k] = relative(*at[2 * k + 1], *at[2 * k]).theta_rad / (turns[k].to_s - turns[k].from_s);
  return rates;
}

/// Sums over turns, from which the best scale and its residual follow.
struct Sums {
  double odometry2 = 0.0, both = 0.0, poses2 = 0.0;

  double scale() const { return poses2 > 0.0 ? both / poses2 : 0.0; }
  double residual() const { return odometry2 - scale() * both; }
};

/// The vertex of the parabola of least squares through the residuals around the least one; nothing at the
/// edge of the range, or where they are flat.
std::optional<double> lowest_s(const std::vector<double>& residuals) {
  const int size = static_cast<int>(residuals.size());
  const int at = static_cast<int>(std::min_element(residuals.begin(), residuals.end()) - residuals.begin());
  const int half = std::min({kParabola, at, size - 1 - at});
  if (half < 2) return std::nullopt;
  double n = 0.0, x2 = 0.0, x4 = 0.0, y = 0.0, xy = 0.0, x2y = 0.0;
  for (int k = -half; k <= half; ++k) {
    const double x = k, value = residuals[static_cast<std::size_t>(at + k)];
    n += 1.0, x2 += x * x, x4 += x * x * x * x;
    y += value, xy += x * value, x2y += x * x * value;
  }
  const double bend = (n * x2y - x2 * y) / (n * x4 - x2 * x2), slope = xy / x2;
  if (!(bend > 0.0)) return std::nullopt;
  const double offset = std::clamp(-0.5 * slope / bend, -1.0 * half, 1.0 * half);
  return kStep_s * (at - kSteps + offset);
}

class DelaySearch {
 public:
  DelaySearch(std::vector<Turn> turns, const Trajectory& poses) : turns_(std::move(turns)) {
    for (int k = -kSteps; k <= kSteps; ++k) rates_.push_back(true_rates(turns_, poses, kStep_s * k));
    // The same turns for every delay: else one would win by what it leaves out.
    used_.resize(turns_.size());
    for (std::size_t k = 0; k < turns_.size(); ++k)
      used_[k] =
          std::all_of(rates_.begin(), rates_.end(), [&](const auto& r) { return std::isfinite(r[k]); });
  }

  std::optional<OdometryDelay> find() {
    if (count() < kFewest) return std::nullopt;
    leave_out_outliers();
    if (count() < kFewest) return std::nullopt;
    OdometryDelay delay;
    delay.turns = count() / kPhases;
    const std::optional<double> best_s = lowest_s(residuals(kParts));
    if (!best_s) return std::nullopt;
    delay.delay_s = *best_s;
    double spread_s2 = 0.0;
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::optional<double> without_s = lowest_s(residuals(part));
      if (!without_s) return std::nullopt;
      spread_s2 += (*without_s - *best_s) * (*without_s - *best_s);
    }
    delay.sigma_s = std::sqrt(spread_s2 * (kParts - 1) / kParts);
    return delay;
  }

 private:
  std::size_t count() const { return static_cast<std::size_t>(std::count(used_.begin(), used_.end(), true)); }

  /// Over all turns used but those of one part of the log; of kParts, there is none.
  Sums sums(const std::vector<double>& rates, std::size_t without_part) const {
    Sums sums;
    for (std::size_t k = 0; k < turns_.size(); ++k) {
      if (!used_[k] || k * kParts / turns_.size() == without_part) continue;
      sums.odometry2 += turns_[k].rate_rad_s * turns_[k].rate_rad_s;
      sums.both += turns_[k].rate_rad_s * rates[k];
      sums.poses2 += rates[k] * rates[k];
    }
    return sums;
  }

  std::vector<double> residuals(std::size_t without_part) const {
    std::vector<double> found;
    for (const std::vector<double>& rates : rates_) found.push_back(sums(rates, without_part).residual());
    return found;
  }

  /// Beyond five times what is usual (1.4826 medians are one standard deviation of a Gaussian).
  void leave_out_outliers() {
    const std::vector<double> all_residuals = residuals(kParts);
    const auto at = static_cast<std::size_t>(std::min_element(all_residuals.begin(), all_residuals.end()) -
                                             all_residuals.begin());
    const double scale = sums(rates_[at], kParts).scale();
    const auto off = [&](std::size_t k) { return std::fabs(turns_[k].rate_rad_s - scale * rates_[at][k]); };
    std::vector<double> all;
    for (std::size_t k = 0; k < turns_.size(); ++k)
      if (used_[k]) all.push_back(off(k));
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    constexpr double kRound_rad_s = 1e-3;  // what the digits of a log leave
    const double most = 5.0 * std::max(1.4826 * *middle, kRound_rad_s);
    for (std::size_t k = 0; k < turns_.size(); ++k) used_[k] = used_[k] && off(k) <= most;
  }

  std::vector<Turn> turns_;
  std::vector<std::vector<double>> rates_;  ///< By delay, then by turn.
  std::vector<bool> used_;                  ///< By turn.
};

}  // namespace

bool OdometryDelay::significant() const {
  return std::fabs(delay_s) > 3.0 * sigma_s && std::fabs(delay_s) > kLeast_s;
}

std::optional<OdometryDelay> estimate_odometry_delay(const Trajectory& odometry, const Trajectory& poses) {
  return DelaySearch(turns_of(odometry), poses).find();
}

}  // namespace parloc::tools
