// How well a scan fits a map in the making (SPEC 9.2): the distance from each end point to the nearest mean
// of earlier end points, among the 3 x 3 cells around it that are occupied and have free space before them.
#pragma once

#include "common/filter/stages.h"
#include "common/slam/matching/tiles.h"

namespace parloc {

/// Pose of a particle: map frame, metres and radians.
struct SlamPose {
  float x = 0, y = 0, theta = 0;
};

/// Nothing near a beam's end.
constexpr float kNoMatch = -1.0f;

/// Bits 3 (dj + 1) + di + 1: the neighbours of cell (i, j) that are occupied.
PARLOC_HD std::uint32_t occupied_around(const TileMap& map, std::int32_t i, std::int32_t j) {
  const std::int32_t in_i = i & (kTileCells - 1), in_j = j & (kTileCells - 1);
  if (in_i > 0 && in_i < kTileCells - 1 && in_j > 0 && in_j < kTileCells - 1) {  // all in one tile
    const std::uint32_t* row = map.tile(i, j).occupied + in_j;
    const int shift = in_i - 1;
    return ((row[-1] >> shift) & 7u) | (((row[0] >> shift) & 7u) << 3) | (((row[1] >> shift) & 7u) << 6);
  }
  return map.occupied_row(i, j - 1) | (map.occupied_row(i, j) << 3) | (map.occupied_row(i, j + 1) << 6);
}

/// Where a beam ends, and a diagonal before that, where there must be free space; cells from the map's
/// origin.
struct EndOfBeam {
  float u, v, before_u, before_v;
};
PARLOC_HD EndOfBeam end_of_beam(float u, float v, float du, float dv) {
  constexpr float kBefore = 1.41421356f;  // cells
  return {u, v, fused(-kBefore, du, u), fused(-kBefore, dv, v)};
}

/// Squared distance from the end to the nearest mean end point that may be the same wall [cells^2], or
/// kNoMatch.
PARLOC_HD float match_end(const TileMap& map, const EndOfBeam& e) {
  const float fi = floor_of(e.u), fj = floor_of(e.v);
  const std::int32_t i = static_cast<std::int32_t>(fi), j = static_cast<std::int32_t>(fj);
  std::uint32_t walls = occupied_around(map, i, j);
  if (walls == 0) return kNoMatch;
  walls &= ~occupied_around(map, static_cast<std::int32_t>(floor_of(e.before_u)),
                            static_cast<std::int32_t>(floor_of(e.before_v)));
  const float in_u = e.u - fi, in_v = e.v - fj;
  const std::int32_t in_i = i & (kTileCells - 1), in_j = j & (kTileCells - 1);
  const bool one_tile = in_i > 0 && in_i < kTileCells - 1 && in_j > 0 && in_j < kTileCells - 1;
  const CellWord* middle = map.tile(i, j).cell + cell_in_tile(i, j);
  float best = kNoMatch;
  for (; walls != 0; walls &= walls - 1) {
    const std::int32_t k = lowest_bit(walls);
    const std::int32_t dj = (k * 11 >> 5) - 1, di = k - 3 * dj - 4;  // k / 3 - 1, k % 3 - 1
    const MeanPlace mean = mean_place(one_tile ? middle[dj * kTileCells + di] : map.cell(i + di, j + dj));
    const float x = static_cast<float>(di) + mean.x - in_u, y = static_cast<float>(dj) + mean.y - in_v;
    const float d = fused(x, x, y * y);
    best = best < 0.0f || d < best ? d : best;
  }
  return best;
}

/// What the sums over beams are made of. Fixed point, so that their order does not matter.
constexpr float kScoreUnits = 65536.0f;
struct MatchRules {
  float inv_resolution = 0;  ///< [cells/m]
  float usable_m = 0;        ///< Beams that end beyond are not matched.
  /// From cells^2 of the end points' distance to the exponent of the score, and to the log-likelihood [nat].
  float score_rate = 0, likelihood_rate = 0;
  std::int32_t no_match = 0;  ///< Log-likelihood of a beam without a match [nat kScoreUnits].
};

/// Sum over beams of exp(-d^2 / sigma): how many of them fit [1/65536].
struct ScoreTerm {
  PARLOC_HD std::int32_t operator()(float d, const MatchRules& r) const {
    return d < 0.0f ? 0 : whole_of(portable_exp(d * r.score_rate) * kScoreUnits);
  }
};
/// Sum over beams of the log-likelihood [nat / 65536].
struct LikelihoodTerm {
  PARLOC_HD std::int32_t operator()(float d, const MatchRules& r) const {
    const float units = max_of(d * r.likelihood_rate * kScoreUnits, static_cast<float>(r.no_match));
    return d < 0.0f ? r.no_match : whole_of(units);
  }
};

/// A pose as beams need it.
struct MatchPose {
  float u, v, cos, sin;
};
PARLOC_HD MatchPose match_pose(const SlamPose& p, const MatchRules& r) {
  const SinCos a = portable_sincos(p.theta);
  return {p.x * r.inv_resolution, p.y * r.inv_resolution, a.cos, a.sin};
}

PARLOC_HD EndOfBeam end_of_beam(const Beams& b, std::size_t m, const MatchPose& p) {
  const float u = fused(p.cos, b.end_x[m], fused(-p.sin, b.end_y[m], p.u));
  const float v = fused(p.sin, b.end_x[m], fused(p.cos, b.end_y[m], p.v));
  const float du = fused(p.cos, b.direction_x[m], -(p.sin * b.direction_y[m]));
  const float dv = fused(p.sin, b.direction_x[m], p.cos * b.direction_y[m]);
  return end_of_beam(u, v, du, dv);
}

/// One beam's part of a sum.
template <class Term>
PARLOC_HD std::int32_t match_term(const TileMap& map, const Beams& b, std::size_t m, const MatchPose& p,
                                  const MatchRules& r, const Term& term) {
  if (b.range_m[m] > r.usable_m) return 0;
  return term(match_end(map, end_of_beam(b, m, p)), r);
}

}  // namespace parloc
