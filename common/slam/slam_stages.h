// THE STAGES OF GRID SLAM, under the same names in cpu/ and cuda/. Poses are in the map frame, whose origin
// is where the robot started; cells are counted from there.
//
// A scan is one sequence of stages, for which the host waits once. Whether the scan may be written is decided
// on the way (SlamTally::fits): if the tables do not reach so far, or there is too little room for its tiles,
// then the stages after find_new_tiles do nothing, and the host makes room and starts again with mark_tiles.
//
// clang-format off
// | stage          | reads                                     | writes                                                     |
// |----------------|-------------------------------------------|------------------------------------------------------------|
// | propose        | poses, maps, scan, motion                 | poses, log_weight, likelihood; what they were: kept        |
// | normalise_scan | log_weight                                | weights, N_eff, resample (common/filter/stages.h)          |
// | resample       | poses, weights                            | ancestor, the other pose buffer (likewise)                 |
// | inherit_tiles  | ancestor, tables, likelihood              | the other likelihoods; when resampled the other tables and references |
// | mark_tiles     | poses, scan                               | touched: tiles that the scan will write; tally.beyond      |
// | find_new_tiles | touched, tables, references               | which of them a particle has to itself not yet; tally      |
// | assign_tiles   | touched, tables, references, tally        | tables: a tile of its own wherever a particle will write   |
// | register_scan  | poses, scan, touched, tables, tally       | cells; occupied bits of the touched tiles                  |
// | report_scan    | poses, ancestor, likelihood, state, tally | all that the host is to know of the scan, in one piece     |
// clang-format on
#pragma once

#include "common/slam/matching/draw.h"
#include "common/slam/propose.h"

namespace parloc {

/// What differs from scan to scan, besides the beams' arrays.
struct SlamInput : StepInput {
  std::size_t matched = 0;       ///< ProposeRules::beams
  std::uint64_t most_tiles = 0;  ///< With more than so many in use the scan is not written.
};

/// What a scan takes.
struct SlamTally {
  std::uint64_t used = 0;    ///< Tiles in use before it is written, the empty one included.
  std::uint64_t needed = 0;  ///< Tiles that it takes besides.
  std::uint32_t beyond = 0;  ///< Particles that see farther than the tables reach; 0 between the steps.
  std::uint32_t fits = 0;    ///< 1: it is written.
};

/// What the particles were before they were moved.
struct KeptParticles {
  float *x = nullptr, *y = nullptr, *theta = nullptr, *log_weight = nullptr, *likelihood = nullptr;  ///< [N]
};

/// Of all stages, so much as they need.
struct SlamArgs {
  ProposeRules rules;  ///< Motion, key and number of beams are those of the input.
  DrawRules draw;
  Beams beams;  ///< The arrays; their shape is that of the input, if there is one.
  std::size_t most_beams = 0;
  const SlamInput* input = nullptr;
  SlamMaps maps;
  const StepState* state = nullptr;
  /// As large as maps.table: theirs once they are resampled, if the state says so. Null: maps.table is
  /// theirs.
  std::uint32_t* other_table = nullptr;
  Particles particles;
  const std::uint32_t* ancestor = nullptr;  ///< [N]
  float* likelihood = nullptr;              ///< [N] Sum of log-weights over the whole way.
  float* other_likelihood = nullptr;        ///< [N]
  KeptParticles kept;
  double reach_m = 0.0, tile_m = 0.0;  ///< Of a scan; of a tile's side.
  std::uint8_t* touched = nullptr;     ///< [N][span.size()] 1: the scan comes there.
  SlamTally* tally = nullptr;
};

/// What a stage works with: `args` with what the input says of this scan.
PARLOC_HD SlamArgs with_input(SlamArgs args) {
  static_cast<ScanShape&>(args.beams) = args.input->scan;
  args.rules.motion = args.input->motion;
  args.rules.key = args.input->key;
  args.rules.beams = args.input->matched;
  return args;
}
PARLOC_HD bool has_resampled(const SlamArgs& args) {
  return args.other_table != nullptr && args.state->resample != 0;
}
/// The maps as they are after inherit_tiles.
PARLOC_HD SlamMaps inherited_maps(const SlamArgs& args) {
  SlamMaps maps = args.maps;
  if (has_resampled(args)) maps.table = args.other_table;
  return maps;
}

PARLOC_HD SlamPose slam_pose(const Particles& p, std::size_t i) {
  return {p.x[i], p.y[i], p.theta[i]};
}
PARLOC_HD void keep_one(const SlamArgs& a, std::size_t i) {
  a.kept.x[i] = a.particles.x[i], a.kept.y[i] = a.particles.y[i], a.kept.theta[i] = a.particles.theta[i];
  a.kept.log_weight[i] = a.particles.log_weight[i];
  a.kept.likelihood[i] = a.likelihood[i];
}
/// Whether the tables hold all that a scan at this pose can reach, a tile more around it (reached_tiles).
PARLOC_HD bool is_covered(const SlamArgs& a, std::size_t i) {
  const TileSpan& s = a.maps.span;
  const auto within = [&a](float at, std::int32_t first, std::int32_t size) {
    return (at - a.reach_m) / a.tile_m >= first + 1 && (at + a.reach_m) / a.tile_m < first + size - 1;
  };
  return within(a.particles.x[i], s.first_i, s.width) && within(a.particles.y[i], s.first_j, s.height);
}
/// Once find_new_tiles knows how many the scan takes. `capacity`: tiles that there is memory for.
PARLOC_HD void decide(SlamTally& t, std::uint64_t used, std::uint64_t needed, std::uint64_t capacity,
                      std::uint64_t most_tiles) {
  const bool covered = t.beyond == 0;
  t.used = used, t.needed = needed, t.beyond = 0;
  t.fits = covered && used + needed <= capacity && used + needed <= most_tiles ? 1 : 0;
}

}  // namespace parloc
