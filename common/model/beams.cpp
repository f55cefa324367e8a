#include "common/model/beams.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/portable.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

enum class BeamClass { invalid, hit, miss };

BeamClass classify(const Scan& scan, const LidarSetup& setup, std::size_t i, BeamCounts& counts) {
  if (is_masked(scan, setup, i)) return ++counts.masked, BeamClass::invalid;
  const float range_m = scan.ranges_m[i];
  if (std::isnan(range_m)) return ++counts.nan, BeamClass::invalid;
  if (std::isinf(range_m)) {
    if (range_m > 0) return ++counts.misses, BeamClass::miss;
    return ++counts.infinite, BeamClass::invalid;
  }
  if (range_m < 0) return ++counts.negative, BeamClass::invalid;
  if (range_m == 0) {
    if (setup.zero_policy == ZeroPolicy::miss) return ++counts.misses, BeamClass::miss;
    return ++counts.zero, BeamClass::invalid;
  }
  if (range_m < setup.range_min_m) return ++counts.below_min, BeamClass::invalid;
  if (range_m >= setup.range_max_m) return ++counts.misses, BeamClass::miss;
  return BeamClass::hit;
}

/// Goes through the indices of the beams to take, in ascending order.
class EvenInAngle {
 public:
  EvenInAngle(const Scan& scan, const LidarSetup& setup)
      : bearings_(scan.bearings_rad),
        total_(scan.ranges_m.size()),
        parts_(std::min(total_, static_cast<std::size_t>(setup.max_beams))) {
    if (setup.own_bearings && bearings_.size() > 1)
      spacing_rad_ = (bearings_.back() - bearings_.front()) / static_cast<double>(total_ - 1);
  }

  /// False when there is none left.
  bool next(std::size_t& index) {
    while (part_ < parts_) {
      const std::size_t i = last_at_or_before(part_++);
      if (taken_ > 0 && i == last_) continue;  // this part has no beam of its own
      ++taken_;
      index = last_ = i;
      return true;
    }
    return false;
  }
  std::size_t taken() const { return taken_; }

 private:
  std::size_t last_at_or_before(std::size_t part) {
    if (spacing_rad_ == 0.0) return part * total_ / parts_;
    // In units of the mean spacing, so that even beams lie at whole numbers, but for their rounding.
    constexpr double rounding = 1e-6;
    const double begins =
        static_cast<double>(part) * static_cast<double>(total_) / static_cast<double>(parts_) + rounding;
    while (walked_ + 1 < total_ && (bearings_[walked_ + 1] - bearings_[0]) / spacing_rad_ <= begins)
      ++walked_;
    return walked_;
  }

  const std::vector<double>& bearings_;
  std::size_t total_, parts_;
  std::size_t part_ = 0, taken_ = 0, last_ = 0, walked_ = 0;
  double spacing_rad_ = 0.0;  // 0: even, as far as is known
};

/// A beam in the base frame at the scan's stamp.
struct PlacedBeam {
  double x_m, y_m;
  SinCos64 direction;

  double end_x_m(double range_m) const { return x_m + range_m * direction.cos; }
  double end_y_m(double range_m) const { return y_m + range_m * direction.sin; }
};

SinCos64 direction_at_rest(const Scan& scan, const LidarSetup& setup, std::size_t i) {
  return portable_sincos64(wrap64(setup.T_base_sensor.theta_rad + beam_bearing_rad(scan, setup, i)));
}

PlacedBeam place_beam(const Scan& scan, const LidarSetup& setup, const OdometryTrack* track, std::size_t i,
                      BeamDirections* directions = nullptr) {
  const Pose& sensor = setup.T_base_sensor;
  if (track == nullptr)
    return {sensor.x_m, sensor.y_m,
            directions != nullptr ? directions->of(scan, setup, i) : direction_at_rest(scan, setup, i)};
  const double bearing_rad = beam_bearing_rad(scan, setup, i);
  const Pose moved = track->motion(scan.stamp_s, scan.stamp_s + beam_time_s(scan, setup, i));
  const SinCos64 r = portable_sincos64(moved.theta_rad);
  return {moved.x_m + r.cos * sensor.x_m - r.sin * sensor.y_m,
          moved.y_m + r.sin * sensor.x_m + r.cos * sensor.y_m,
          portable_sincos64(wrap64(moved.theta_rad + sensor.theta_rad + bearing_rad))};
}

void append_beam(BeamTable& t, const PlacedBeam& beam, float range_m, const SensorConfig& sensor,
                 double inv_resolution) {
  t.origin_x.push_back(static_cast<float>(beam.x_m));
  t.origin_y.push_back(static_cast<float>(beam.y_m));
  t.direction_x.push_back(static_cast<float>(beam.direction.cos));
  t.direction_y.push_back(static_cast<float>(beam.direction.sin));
  t.range_m.push_back(range_m);
  const float lambda = static_cast<float>(sensor.lambda_short);
  t.short_density.push_back(static_cast<float>(sensor.z_short) * lambda * portable_exp(-lambda * range_m));
  t.end_x.push_back(static_cast<float>(beam.end_x_m(range_m) * inv_resolution));
  t.end_y.push_back(static_cast<float>(beam.end_y_m(range_m) * inv_resolution));
}

void clear(BeamTable& t) {
  for (const auto array : kBeamArrays) (t.*array).clear();
  t.count = t.hits = 0;
}

}  // namespace

namespace {
constexpr SinCos64 kNotAskedFor{2.0, 2.0};
}

void BeamDirections::expect(const Scan& scan, const LidarSetup& setup) {
  const Pose &known = T_base_sensor_, &now = setup.T_base_sensor;
  const bool same = known.x_m == now.x_m && known.y_m == now.y_m && known.theta_rad == now.theta_rad &&
                    upside_down_ == setup.upside_down && angle_min_rad_ == setup.angle_min_rad &&
                    angle_step_rad_ == setup.angle_step_rad && direction_.size() == scan.ranges_m.size();
  const bool were_even = even_;
  even_ = !setup.own_bearings;
  if (same && even_ && were_even) return;
  T_base_sensor_ = now;
  upside_down_ = setup.upside_down;
  angle_min_rad_ = setup.angle_min_rad, angle_step_rad_ = setup.angle_step_rad;
  direction_.assign(scan.ranges_m.size(), kNotAskedFor);
}

const SinCos64& BeamDirections::of(const Scan& scan, const LidarSetup& setup, std::size_t i) {
  SinCos64& d = direction_[i];
  if (d.cos == kNotAskedFor.cos) d = direction_at_rest(scan, setup, i);
  return d;
}

// Distances rounded up a little, for they are bounds.
void measure_origins(BeamTable& t) {
  t.first_origin_x = t.count > 0 ? t.origin_x[0] : 0.0f;
  t.first_origin_y = t.count > 0 ? t.origin_y[0] : 0.0f;
  float spread_m = 0.0f, reach_m = 0.0f;
  for (std::size_t m = 0; m < t.count; ++m) {
    const float dx = t.origin_x[m] - t.first_origin_x, dy = t.origin_y[m] - t.first_origin_y;
    spread_m = std::max(spread_m, std::sqrt(dx * dx + dy * dy));
    reach_m = std::max(reach_m, std::sqrt(t.origin_x[m] * t.origin_x[m] + t.origin_y[m] * t.origin_y[m]));
  }
  t.origin_spread_m = spread_m * 1.001f;
  t.origin_reach_m = reach_m * 1.001f;
}

void select_beams(const Scan& scan, const LidarSetup& setup, const OdometryTrack* track,
                  const SensorConfig& sensor, double resolution_m, BeamTable& table, BeamCounts& counts,
                  BeamDirections* directions) {
  clear(table);
  if (directions != nullptr) directions->expect(scan, setup);
  table.range_max_m = static_cast<float>(setup.range_max_m);
  const double inv_resolution = 1.0 / resolution_m;
  counts.total += scan.ranges_m.size();

  // Hits first, misses behind them: two straight loops for the models, no branch per beam.
  for (const BeamClass pass : {BeamClass::hit, BeamClass::miss}) {
    BeamCounts ignored;
    BeamCounts& c = pass == BeamClass::hit ? counts : ignored;  // count each beam once
    EvenInAngle chosen(scan, setup);
    std::size_t i = 0;
    while (chosen.next(i)) {
      if (classify(scan, setup, i, c) != pass) continue;
      append_beam(table, place_beam(scan, setup, track, i, directions),
                  pass == BeamClass::hit ? scan.ranges_m[i] : table.range_max_m, sensor, inv_resolution);
    }
    c.considered += chosen.taken();
    if (pass == BeamClass::hit) table.hits = table.range_m.size();
  }
  table.count = table.range_m.size();
  measure_origins(table);
}

void select_beams(const Scan& scan, const ScanConfig& config, const SensorConfig& sensor, double resolution_m,
                  BeamTable& table, BeamCounts& counts) {
  select_beams(scan, lidar_setup(scan, config), nullptr, sensor, resolution_m, table, counts);
}

std::vector<EndPoint> end_points(const Scan& scan, const LidarSetup& setup, const OdometryTrack* track) {
  std::vector<EndPoint> points;
  BeamCounts ignored;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const float range_m = scan.ranges_m[i];
    if (classify(scan, setup, i, ignored) != BeamClass::hit) continue;
    const PlacedBeam beam = place_beam(scan, setup, track, i);
    points.push_back({static_cast<float>(beam.end_x_m(range_m)), static_cast<float>(beam.end_y_m(range_m))});
  }
  return points;
}

namespace {

/// Appends entries [first, first + count) of `from`, a golden section of them apart (a stride without a
/// common divisor, so that each comes once).
void append_scattered(const BeamTable& from, std::size_t first, std::size_t count, BeamTable& to) {
  std::size_t stride = count * 618 / 1000 + 1;
  while (std::gcd(stride, count) != 1) ++stride;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t m = first + k * stride % count;
    for (const auto array : kBeamArrays) (to.*array).push_back((from.*array)[m]);
  }
}

}  // namespace

void scatter_beams(const BeamTable& table, BeamTable& out) {
  clear(out);
  static_cast<ScanShape&>(out) = table;
  append_scattered(table, 0, table.hits, out);
  append_scattered(table, table.hits, table.count - table.hits, out);
  measure_origins(out);
}

}  // namespace parloc
