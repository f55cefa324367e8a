// From settings and arrays to stage arguments: the same for every backend, whatever space the arrays are in.
#pragma once

#include "common/filter/kld.h"
#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/math/normal_quantile.h"
#include "common/math/portable64.h"
#include "common/model/beams.h"

namespace parloc {

/// `padded`: an array of at least (width + 2) x (height + 2), or null. Where its cell (0, 0) is; null for
/// null.
template <class T>
const T* first_cell(const T* padded, const GridMap& map) {
  return padded == nullptr ? nullptr : padded + (map.width + 2) + 1;
}

/// `skip`: lines of a skip field (common/map/rays/skip_field.h), or null for models that cast no rays.
inline RayMap bind_ray_map(const std::uint8_t* skip, SkipPlanes planes, const GridMap& map,
                           const Walls& walls = {}) {
  return {first_cell(skip, map),
          map.width,
          map.height,
          map.width + 2,
          static_cast<float>(map.resolution_m),
          static_cast<float>(1.0 / map.resolution_m),
          planes,
          walls};
}

/// `table`: a likelihood table (common/model/likelihood_field.h) whose values are in `unit_nat`, or null for
/// models that do not look up.
inline LikelihoodField bind_field(const std::uint32_t* table, float unit_nat, const SensorConfig& sensor,
                                  const GridMap& map) {
  return {first_cell(table, map), map.width, map.height, map.width + 2, sensor.lookup, unit_nat};
}

/// The table where it is, for a backend that works in host memory.
inline Beams bind_beams(const BeamTable& t) {
  return {t,
          t.origin_x.data(),
          t.origin_y.data(),
          t.direction_x.data(),
          t.direction_y.data(),
          t.range_m.data(),
          t.short_density.data(),
          t.end_x.data(),
          t.end_y.data()};
}

inline RayTraceArgs bind_rays(const Particles& particles, const RayMap& map, const Beams& beams,
                              const SensorConfig& sensor) {
  return {.particles = particles,
          .map = map,
          .beams = beams,
          .caster = sensor.caster,
          .fixed_step_cells = static_cast<float>(sensor.fixed_step_cells)};
}

/// Exponent of the likelihood of a scan. M beams that are worth M_eff independent ones: M_eff / M.
inline float bind_tempering(const SensorConfig& c, const ScanShape& scan) {
  const std::size_t beams = casts_rays(c.model) ? scan.count : scan.hits;
  if (c.tempering > 0.0) return static_cast<float>(c.tempering);
  return c.effective_beams < static_cast<double>(beams)
             ? static_cast<float>(c.effective_beams / static_cast<double>(beams))
             : 1.0f;
}

/// Independent beams that a scan counts for.
inline float bind_scan_worth(const SensorConfig& c, const ScanShape& scan) {
  const std::size_t beams = casts_rays(c.model) ? scan.count : scan.hits;
  return bind_tempering(c, scan) * static_cast<float>(beams);
}

inline RecoveryRates bind_recovery(const RecoveryConfig& c) {
  if (c.recovery_alpha_slow <= 0.0 || c.recovery_alpha_fast <= 0.0) return {};
  return {true,
          portable_log64(c.recovery_alpha_slow),
          portable_log64(1.0 - c.recovery_alpha_slow),
          portable_log64(c.recovery_alpha_fast),
          portable_log64(1.0 - c.recovery_alpha_fast),
          portable_log64(c.recovery_margin)};
}

/// A full turn has a whole number of bins, 1 to 4096.
inline KldRule bind_kld(const KldConfig& c, std::int64_t fewest, std::int64_t most) {
  const double turn_rad = 2.0 * kPi;
  const double headings = __builtin_floor(turn_rad / c.bin_size_theta + 0.5);
  const std::int32_t bins =
      headings < 1.0 ? 1 : (headings > 4096.0 ? 4096 : static_cast<std::int32_t>(headings));
  return {c.pf_z > 0.0 ? c.pf_z : normal_quantile(1.0 - c.delta),
          c.pf_err,
          static_cast<std::uint32_t>(fewest),
          static_cast<std::uint32_t>(most),
          static_cast<float>(1.0 / c.bin_size_xy),
          static_cast<float>(static_cast<double>(bins) / turn_rad),
          bins};
}

/// `cell`: the map's free cells (common/filter/start.h) in the backend's space.
inline FreeSpace bind_free_space(const std::uint32_t* cell, std::size_t count, const GridMap& map) {
  return {cell, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(map.width),
          static_cast<float>(map.resolution_m)};
}

}  // namespace parloc
