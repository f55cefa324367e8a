#include "common/model/continuous_odometry.h"

#include <algorithm>
#include <cmath>

namespace parloc {
namespace {

/// Stamps of scans and of odometry are made by different clocks and hands: they are off by as much.
constexpr double kJitter_s = 0.1;
/// A speed is not taken over less: stamps jitter.
constexpr double kShortest_s = 0.02;
/// Nothing is known of a longer time.
constexpr double kLongest_s = 10.0;
/// So many stamps in a row that do not advance are a clock that stands still. Fewer are several LiDARs, or
/// packets that came together.
constexpr int kStandsStill = 3;
/// So many readings the mean time between them goes back.
constexpr int kPaceReadings = 20;
/// What a robot did last it goes on doing for as long.
constexpr double kInertia_s = 1.0;
/// As kJitter_s, for turns: what a robot turns while its stamps are off.
constexpr double kTurnSlack_rad = 0.2;

/// The time that a step is taken for to have a speed: after a break that a burst of stamps leaves, too, it is
/// that of one reading.
double time_of(double step_s, double pace_s) {
  return std::max(kShortest_s, std::min(step_s, pace_s));
}

/// Another time between readings goes into their mean. Stamps that step back count as they are, so that a
/// burst and the break before it make up for each other.
void learn_pace(OdometryMemory& memory, double stamps_s) {
  if (!std::isfinite(stamps_s)) return;
  memory.paced = std::min(memory.paced + 1, kPaceReadings);
  const double counted_s = std::clamp(stamps_s, -kLongest_s, kLongest_s);
  memory.pace_s = std::max(0.0, memory.pace_s + (counted_s - memory.pace_s) / memory.paced);
}

}  // namespace

void ContinuousOdometry::clear() {
  last_.reset();
  jumps_ = invalid_ = stalled_ = 0;
}

/// The comparisons are such that what is not a number is impossible.
bool ContinuousOdometry::possible(const Pose& step, double stamps_s, bool clock_runs) const {
  const double length_m = std::sqrt(step.x_m * step.x_m + step.y_m * step.y_m);
  const OdometryMemory& last = *last_;
  if (!clock_runs && length_m <= limits_.max_jump_m) return true;
  if (!clock_runs && last.stood_still == kStandsStill) return false;
  // Readings that were taken evenly may be stamped together, hundredths of a second apart, and then none for
  // long. Their number knows better how long a step took.
  const double took_s = std::max(stamps_s, last.pace_s);
  double speed_mps = limits_.max_speed_mps;
  if (last.step_s > 0.0) {
    const double before_mps = distance_m({}, last.step) / time_of(last.step_s, last.pace_s);
    speed_mps = std::min(speed_mps, before_mps + limits_.max_acceleration_mps2 * (last.since_s + took_s));
  }
  return length_m <= speed_mps * (took_s + kJitter_s) &&
         std::fabs(step.theta_rad) <= limits_.max_turn_rate_rad_s * took_s + kTurnSlack_rad;
}

std::optional<OdometryReading> ContinuousOdometry::take(double stamp_s, const Pose& raw) {
  if (!is_finite(raw)) {
    ++invalid_;
    return std::nullopt;
  }
  if (!last_) {
    last_.emplace();
    last_->raw = last_->pose = raw;
    last_->stamp_s = stamp_s;
    return OdometryReading{raw};
  }
  OdometryMemory& last = *last_;
  const double stamps_s = std::min(stamp_s - last.stamp_s, kLongest_s);
  const bool advances = stamps_s > 0.0;
  stalled_ += advances ? 0 : 1;
  last.stood_still = advances ? 0 : std::min(last.stood_still + 1, kStandsStill);
  const bool clock_runs = last.stood_still < kStandsStill && advances;
  const double elapsed_s = advances ? stamps_s : last.stood_still == kStandsStill ? kGuess_s : 0.0;

  OdometryReading reading;
  reading.elapsed_s = elapsed_s;
  Pose step = relative(raw, last.raw);
  reading.jumped = !possible(step, clock_runs ? stamps_s : 0.0, clock_runs);
  if (reading.jumped) {
    ++jumps_;
    const double part = last.step_s > 0.0 ? std::min(elapsed_s, kInertia_s) /
                                                std::max({last.step_s, last.pace_s, kShortest_s})
                                          : 0.0;
    step = along_arc(last.step, part);
    last.since_s = std::min(last.since_s + elapsed_s, kLongest_s);
    last.rebased = true;
  } else if (elapsed_s > 0.0) {
    last.step = step;
    last.step_s = elapsed_s;
    last.since_s = 0.0;
  }
  learn_pace(last, stamps_s);
  // Without a jump, exactly what came.
  reading.pose = last.pose = last.rebased ? compose(last.pose, step) : raw;
  last.raw = raw;
  last.stamp_s = stamp_s;
  return reading;
}

}  // namespace parloc
