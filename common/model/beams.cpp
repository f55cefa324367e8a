#include "common/model/beams.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/portable.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

enum class BeamClass { invalid, hit, miss };

BeamClass classify(float range_m, double range_min_m, double range_max_m, ZeroPolicy zero,
                   BeamCounts& counts) {
  if (std::isnan(range_m)) return ++counts.nan, BeamClass::invalid;
  if (std::isinf(range_m)) {
    if (range_m > 0) return ++counts.misses, BeamClass::miss;
    return ++counts.infinite, BeamClass::invalid;
  }
  if (range_m < 0) return ++counts.negative, BeamClass::invalid;
  if (range_m == 0) {
    ++counts.zero;
    return zero == ZeroPolicy::miss ? BeamClass::miss : BeamClass::invalid;
  }
  if (range_m < range_min_m) return ++counts.below_min, BeamClass::invalid;
  if (range_m >= range_max_m) return ++counts.misses, BeamClass::miss;
  return BeamClass::hit;
}

struct SensorFrame {
  double x_m, y_m, yaw_rad, inv_resolution;
};

void append_beam(BeamTable& t, const SensorFrame& f, double bearing_rad, float range_m,
                 const SensorConfig& sensor) {
  const SinCos64 a = portable_sincos64(wrap64(f.yaw_rad + bearing_rad));
  t.origin_x.push_back(static_cast<float>(f.x_m));
  t.origin_y.push_back(static_cast<float>(f.y_m));
  t.direction_x.push_back(static_cast<float>(a.cos));
  t.direction_y.push_back(static_cast<float>(a.sin));
  t.range_m.push_back(range_m);
  const float lambda = static_cast<float>(sensor.lambda_short);
  t.short_density.push_back(static_cast<float>(sensor.z_short) * lambda * portable_exp(-lambda * range_m));
  t.end_x.push_back(static_cast<float>((f.x_m + range_m * a.cos) * f.inv_resolution));
  t.end_y.push_back(static_cast<float>((f.y_m + range_m * a.sin) * f.inv_resolution));
}

void clear(BeamTable& t) {
  for (auto* v : {&t.origin_x, &t.origin_y, &t.direction_x, &t.direction_y, &t.range_m, &t.short_density,
                  &t.end_x, &t.end_y})
    v->clear();
  t.count = t.hits = 0;
}

}  // namespace

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

void select_beams(const Scan& scan, const ScanConfig& config, const SensorConfig& sensor, double resolution_m,
                  BeamTable& table, BeamCounts& counts) {
  clear(table);
  const double range_min_m = scan.range_min_m > 0 ? scan.range_min_m : config.laser_min_range;
  const double range_max_m = scan.range_max_m > 0 ? scan.range_max_m : config.laser_max_range;
  table.range_max_m = static_cast<float>(range_max_m);
  const SensorFrame frame{scan.T_base_sensor.x_m, scan.T_base_sensor.y_m, scan.T_base_sensor.theta_rad,
                          1.0 / resolution_m};

  const std::size_t total = scan.ranges_m.size();
  const std::size_t wanted = static_cast<std::size_t>(config.max_beams);
  const std::size_t considered = total < wanted ? total : wanted;
  counts.total += total;
  counts.considered += considered;

  // Hits first, misses behind them: two straight loops for the models, no branch per beam.
  for (const BeamClass pass : {BeamClass::hit, BeamClass::miss}) {
    BeamCounts ignored;
    for (std::size_t k = 0; k < considered; ++k) {
      const std::size_t i = k * total / considered;
      BeamCounts& c = pass == BeamClass::hit ? counts : ignored;  // count each beam once
      if (classify(scan.ranges_m[i], range_min_m, range_max_m, config.zero_policy, c) != pass) continue;
      const double bearing_rad = scan.angle_min_rad + static_cast<double>(i) * scan.angle_step_rad;
      append_beam(table, frame, bearing_rad, pass == BeamClass::hit ? scan.ranges_m[i] : table.range_max_m,
                  sensor);
    }
    if (pass == BeamClass::hit) table.hits = table.range_m.size();
  }
  table.count = table.range_m.size();
  measure_origins(table);
}

namespace {

/// Appends entries [first, first + count) of `from`, a golden section of them apart (a stride without a
/// common divisor, so that each comes once).
void append_scattered(const BeamTable& from, std::size_t first, std::size_t count, BeamTable& to) {
  std::size_t stride = count * 618 / 1000 + 1;
  while (std::gcd(stride, count) != 1) ++stride;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t m = first + k * stride % count;
    to.origin_x.push_back(from.origin_x[m]);
    to.origin_y.push_back(from.origin_y[m]);
    to.direction_x.push_back(from.direction_x[m]);
    to.direction_y.push_back(from.direction_y[m]);
    to.range_m.push_back(from.range_m[m]);
    to.short_density.push_back(from.short_density[m]);
    to.end_x.push_back(from.end_x[m]);
    to.end_y.push_back(from.end_y[m]);
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
