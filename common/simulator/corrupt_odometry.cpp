#include "common/simulator/corrupt_odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/math/philox.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// The third word of the counter: who draws.
enum Purpose : std::uint32_t { kNoise = 0, kSlip = 1, kSlipSize = 2, kHide = 3, kReset = 4 };

Philox4x32 draw(std::size_t index, Purpose purpose, std::uint64_t seed) {
  return philox(static_cast<std::uint32_t>(index), 0u, Stream::corrupted_odometry, purpose, seed);
}

double unit(std::uint32_t word) {
  return static_cast<double>(uniform_unit(word));
}

double length_m(const Pose& d) {
  return std::sqrt(d.x_m * d.x_m + d.y_m * d.y_m);
}

/// That of a Poisson process has at least one event within `dt_s`.
double event_probability(double per_min, double dt_s) {
  return 1.0 - portable_exp64(-per_min / 60.0 * dt_s);
}

/// What a record's own motion is given besides.
struct Slip {
  double rotation_rad = 0.0, translation_m = 0.0;
};

/// Slips belong to the step from one scan to the next: drawn there, put into one record of that step.
std::vector<Slip> draw_slips(const std::vector<LogRecord>& records, const OdometryCorruption& c,
                             std::uint64_t seed) {
  constexpr double kMoves_m = 0.01, kMoves_rad = 0.5 * kPi / 180.0;
  std::vector<Slip> slips(records.size());
  std::optional<std::size_t> before;
  for (std::size_t k = 0; k < records.size(); ++k) {
    if (records[k].kind != RecordKind::scan) continue;
    const std::optional<std::size_t> last = std::exchange(before, k);
    if (!last) continue;
    const Philox4x32 event = draw(k, kSlip, seed), how = draw(k, kSlipSize, seed);
    const double dt_s = std::max(records[k].stamp_s - records[*last].stamp_s, 0.0);
    if (unit(event.w[0]) >= event_probability(c.slips_per_min, dt_s)) continue;
    const Pose d = relative(records[k].odometry, records[*last].odometry);
    if (!c.slip_standing && length_m(d) <= kMoves_m && std::fabs(d.theta_rad) <= kMoves_rad) continue;
    const bool rotates = c.slip_kind == OdometryCorruption::Slip::rotation ||
                         (c.slip_kind == OdometryCorruption::Slip::both && unit(event.w[1]) < 0.5);
    const double sign = unit(event.w[2]) < 0.5 ? 1.0 : -1.0, size = unit(how.w[0]);
    const std::size_t at = *last + 1 + uniform_below(how.w[1], static_cast<std::uint32_t>(k - *last));
    if (rotates) {
      slips[at].rotation_rad = sign * (c.least_slip_rad + (c.most_slip_rad - c.least_slip_rad) * size);
    } else {
      slips[at].translation_m = sign * (c.least_slip_m + (c.most_slip_m - c.least_slip_m) * size);
    }
  }
  return slips;
}

/// Hides motion until there was enough of it.
class Hiding {
 public:
  Hiding(const OdometryCorruption& c, std::uint64_t seed) : c_(c), seed_(seed) {}

  /// What the wheels report of the motion d.
  Pose seen(const Pose& d, const LogRecord& record, std::size_t index, double dt_s,
            std::vector<CorruptionEvent>& events) {
    const Philox4x32 r = draw(index, kHide, seed_);
    if (!hides_ && unit(r.w[0]) < event_probability(c_.hidden_per_min, dt_s)) {
      hides_ = true;
      left_rad_ = c_.least_slip_rad + (c_.most_slip_rad - c_.least_slip_rad) * unit(r.w[1]);
      left_m_ = c_.least_slip_m + (c_.most_slip_m - c_.least_slip_m) * unit(r.w[1]);
    }
    if (!hides_) return d;
    const double whole = std::max(std::fabs(d.theta_rad) / left_rad_, length_m(d) / left_m_);
    const double part = whole <= 1.0 ? 1.0 : 1.0 / whole;  // the first part of the step is hidden
    hidden_rad_ += part * d.theta_rad;
    hidden_m_ += part * length_m(d);
    left_rad_ -= part * std::fabs(d.theta_rad);
    left_m_ -= part * length_m(d);
    if (whole >= 1.0 || left_rad_ <= 0.0 || left_m_ <= 0.0) end(record.stamp_s, events);
    return {(1.0 - part) * d.x_m, (1.0 - part) * d.y_m, (1.0 - part) * d.theta_rad};
  }

  /// Tells what was hidden so far.
  void end(double stamp_s, std::vector<CorruptionEvent>& events) {
    if (hides_ && (hidden_rad_ != 0.0 || hidden_m_ != 0.0)) {
      events.push_back({stamp_s, CorruptionEvent::Kind::hidden_rotation, hidden_rad_});
      events.push_back({stamp_s, CorruptionEvent::Kind::hidden_translation, hidden_m_});
    }
    hides_ = false;
    hidden_rad_ = hidden_m_ = 0.0;
  }

 private:
  const OdometryCorruption& c_;
  std::uint64_t seed_;
  bool hides_ = false;
  double left_rad_ = 0.0, left_m_ = 0.0, hidden_rad_ = 0.0, hidden_m_ = 0.0;
};

/// The motion d with errors, as a motion in the robot's frame.
Pose with_errors(const Pose& d, const OdometryCorruption& c, const Slip& slip, std::size_t index, double dt_s,
                 std::uint64_t seed) {
  constexpr double kStands_m = 0.001, kStands_rad = 0.05 * kPi / 180.0;
  const double drive_m = length_m(d), turn_rad = std::fabs(d.theta_rad);
  const Normals n = normals(draw(index, kNoise, seed));
  const SinCos64 along = portable_sincos64(portable_atan2_64(d.y_m, d.x_m));
  double step_m =
      drive_m * c.scale_translation + c.noise_translation * std::sqrt(drive_m) * static_cast<double>(n.n[0]);
  double rotation_rad = d.theta_rad * c.scale_rotation +
                        c.noise_rotation * std::sqrt(turn_rad) * static_cast<double>(n.n[1]) +
                        c.noise_rotation_per_m * std::sqrt(drive_m) * static_cast<double>(n.n[2]) +
                        c.drift_rad_per_m * drive_m + slip.rotation_rad;
  if (drive_m < kStands_m && turn_rad < kStands_rad) rotation_rad += c.gyro_drift_rad_per_s * dt_s;
  // Wheels that spin report more of the way that they go, which may be backwards.
  step_m += along.cos < 0.0 && drive_m > kStands_m ? -slip.translation_m : slip.translation_m;
  return {step_m * along.cos, step_m * along.sin, rotation_rad};
}

/// The odometry between resets, with stamps that advance.
struct Stretch {
  std::vector<double> stamps_s;
  std::vector<Pose> poses;
};

Pose pose_within(const Stretch& stretch, double stamp_s) {
  const auto above = std::upper_bound(stretch.stamps_s.begin(), stretch.stamps_s.end(), stamp_s);
  if (above == stretch.stamps_s.begin()) return stretch.poses.front();
  if (above == stretch.stamps_s.end()) return stretch.poses.back();
  const auto i = static_cast<std::size_t>(above - stretch.stamps_s.begin());
  const double part = (stamp_s - stretch.stamps_s[i - 1]) / (stretch.stamps_s[i] - stretch.stamps_s[i - 1]);
  const Pose d = relative(stretch.poses[i], stretch.poses[i - 1]);
  return compose(stretch.poses[i - 1], {part * d.x_m, part * d.y_m, part * d.theta_rad});
}

/// Gives scans the odometry of another time, interpolated, but not across a reset.
void shift_odometry(std::vector<LogRecord>& records, const std::vector<std::size_t>& stretch_of,
                    double offset_s) {
  std::vector<Stretch> stretches(stretch_of.empty() ? 0 : stretch_of.back() + 1);
  for (std::size_t k = 0; k < records.size(); ++k) {
    Stretch& s = stretches[stretch_of[k]];
    if (!s.stamps_s.empty() && records[k].stamp_s <= s.stamps_s.back()) continue;
    s.stamps_s.push_back(records[k].stamp_s);
    s.poses.push_back(records[k].odometry);
  }
  for (std::size_t k = 0; k < records.size(); ++k)
    if (records[k].kind == RecordKind::scan)
      records[k].odometry = pose_within(stretches[stretch_of[k]], records[k].stamp_s - offset_s);
}

void keep_every_scan(std::vector<LogRecord>& records, int keep_every) {
  std::size_t scan = 0;
  std::erase_if(records, [&](const LogRecord& r) {
    return r.kind == RecordKind::scan && scan++ % static_cast<std::size_t>(keep_every) != 0;
  });
}

}  // namespace

std::vector<CorruptionEvent> corrupt_odometry(std::vector<LogRecord>& records, const OdometryCorruption& c,
                                              std::uint64_t seed) {
  std::vector<CorruptionEvent> events;
  if (records.empty()) return events;
  const std::vector<Slip> slips = draw_slips(records, c, seed);
  Hiding hiding(c, seed);
  std::vector<std::size_t> stretch_of{0};
  Pose was = records[0].odometry, out = was;
  for (std::size_t k = 1; k < records.size(); ++k) {
    LogRecord& record = records[k];
    const double dt_s = std::max(record.stamp_s - records[k - 1].stamp_s, 0.0);
    Pose d = relative(record.odometry, was);
    was = record.odometry;
    d = hiding.seen(d, record, k, dt_s, events);
    out = compose(out, with_errors(d, c, slips[k], k, dt_s, seed));
    if (slips[k].rotation_rad != 0.0)
      events.push_back({record.stamp_s, CorruptionEvent::Kind::slip_rotation, slips[k].rotation_rad});
    if (slips[k].translation_m != 0.0)
      events.push_back({record.stamp_s, CorruptionEvent::Kind::slip_translation, slips[k].translation_m});
    stretch_of.push_back(stretch_of.back());
    if (unit(draw(k, kReset, seed).w[0]) < event_probability(c.resets_per_min, dt_s)) {
      out = {};
      ++stretch_of.back();
      events.push_back({record.stamp_s, CorruptionEvent::Kind::reset, 0.0});
    }
    record.odometry = out;
  }
  hiding.end(records.back().stamp_s, events);
  if (c.offset_s != 0.0) shift_odometry(records, stretch_of, c.offset_s);
  if (c.keep_every > 1) keep_every_scan(records, c.keep_every);
  return events;
}

}  // namespace parloc
