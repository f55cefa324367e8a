// From settings and arrays to stage arguments: the same for every backend, whatever space the arrays are in.
#pragma once

#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/model/beams.h"

namespace parloc {

/// `padded`: an array of at least (width + 2) x (height + 2), or null. Where its cell (0, 0) is; null for
/// null.
template <class T>
const T* first_cell(const T* padded, const GridMap& map) {
  return padded == nullptr ? nullptr : padded + (map.width + 2) + 1;
}

/// `skip`: lines of a skip field (common/map/skip_field.h), or null for models that cast no rays.
inline RayMap bind_ray_map(const std::uint8_t* skip, std::int32_t skip_plane, const GridMap& map,
                           const Walls& walls = {}) {
  return {first_cell(skip, map),
          map.width,
          map.height,
          map.width + 2,
          static_cast<float>(map.resolution_m),
          static_cast<float>(1.0 / map.resolution_m),
          skip_plane,
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
  return {particles, map, beams, sensor.caster, static_cast<float>(sensor.fixed_step_cells), nullptr};
}

/// Exponent of the likelihood of a scan. M beams that are worth M_eff independent ones: M_eff / M.
inline float bind_tempering(const SensorConfig& c, const ScanShape& scan) {
  const std::size_t beams = casts_rays(c.model) ? scan.count : scan.hits;
  if (c.tempering > 0.0) return static_cast<float>(c.tempering);
  return c.effective_beams < static_cast<double>(beams)
             ? static_cast<float>(c.effective_beams / static_cast<double>(beams))
             : 1.0f;
}

/// What the models that ask all particles about a beam need besides.
struct JudgeArrays {
  const std::uint32_t* squared_cells = nullptr;  ///< Null for models that cast rays.
  BeamVotes votes;
  const StepState* state = nullptr;
};

inline WeightArgs bind_weight(const RayTraceArgs& rays, const LikelihoodField& field,
                              const SensorConfig& sensor, const JudgeArrays& judge) {
  const std::uint32_t* squared_cells = sensor.do_beamskip ? judge.squared_cells : nullptr;
  return {rays,
          sensor.model,
          bind_tempering(sensor, rays.beams),
          bind_ray_models(sensor, rays.beams.range_max_m),
          field,
          bind_beam_skip(sensor, squared_cells, rays.map.width, rays.map.height, rays.map.resolution_m),
          judge.votes,
          judge.state};
}

inline NormaliseArgs bind_normalise(const Particles& particles, const Weights& weights,
                                    const ResampleConfig& resample, StepState* state) {
  return {particles, weights, resample.threshold, resample.threshold >= 1.0, state};
}

}  // namespace parloc
