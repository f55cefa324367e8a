// Correlative scan matching (Olson 2009): the best pose of a whole window around a start, however many lesser
// peaks lie between. Two resolutions: coarse blocks of poses are bounded from above, and only those whose
// bound beats the best pose so far are looked at pose by pose. Like HillClimb it asks for sums over beams.
#pragma once

#include "common/slam/matching/match_beam.h"

namespace parloc {

struct SearchRules {
  std::int32_t cells = 0;  ///< Reach along x and along y [cells].
  std::int32_t turns = 0;  ///< Reach in heading [steps].
  float resolution_m = 0, step_theta = 0;
  /// What a pose at the rim of the window must score more, per beam, and those between by squares: without
  /// any, the search slides along corridors, back to what is known.
  float bias = 0;
  float inv_cells_sq = 0, inv_turns_sq = 0;  ///< 1 / reach^2, 0 without reach.

  PARLOC_HD bool any() const { return cells > 0 || turns > 0; }
};

class WideSearch {
 public:
  static constexpr std::int32_t kBlock = 8;  ///< Poses of a block along x and along y, a cell apart.
  static constexpr int kMostBlocks = 2048;   ///< In a window.
  static constexpr int kMostLooked = 32;     ///< Blocks looked at pose by pose; then the best so far counts.
  static constexpr int kBatch = 128;         ///< Blocks bounded in one round.
  static constexpr int kMostRounds = (kMostBlocks + kBatch - 1) / kBatch + kMostLooked;

  PARLOC_HD static std::int32_t blocks_along(std::int32_t cells) { return (2 * cells + kBlock) / kBlock; }
  PARLOC_HD static std::int32_t blocks(const SearchRules& r) {
    return (2 * r.turns + 1) * blocks_along(r.cells) * blocks_along(r.cells);
  }

  PARLOC_HD void begin(const SlamPose& start, const SearchRules& r, std::size_t beams) {
    start_ = best_ = start;
    best_total_ = 0;
    bias_ = r.bias * kScoreUnits * static_cast<float>(beams);
    along_ = blocks_along(r.cells);
    blocks_ = blocks(r);
    bounded_ = looked_ = 0;
    block_ = -1;
    done_ = false;
  }
  PARLOC_HD bool done() const { return done_; }
  /// Asked for are upper bounds of blocks (block_term), else scores of poses.
  PARLOC_HD bool asks_bounds() const { return bounded_ < blocks_; }
  PARLOC_HD int wanted() const {
    const std::int32_t left = blocks_ - bounded_;
    return asks_bounds() ? (left < kBatch ? left : kBatch) : kBlock * kBlock;
  }
  PARLOC_HD SlamPose candidate(int k, const SearchRules& r) const {
    if (asks_bounds()) return pose(offset(bounded_ + k, 0, r), r);
    return pose(offset(block_, k, r), r);
  }
  /// `bound`: room for kMostBlocks, kept from call to call.
  PARLOC_HD void take(const std::int32_t* sum, std::int32_t* bound, const SearchRules& r) {
    if (asks_bounds()) {
      const int n = wanted();
      for (int k = 0; k < n; ++k) bound[bounded_ + k] = sum[k] - least_bias(bounded_ + k, r);
      bounded_ += n;
      if (asks_bounds()) return;
    } else {
      for (int k = 0; k < kBlock * kBlock; ++k) {
        const Offset o = offset(block_, k, r);
        const std::int32_t total = sum[k] - bias(o, r);
        const bool inside = o.i <= r.cells && o.j <= r.cells;
        if (inside && total > best_total_) best_total_ = total, best_ = pose(o, r);
      }
      bound[block_] = 0;
      ++looked_;
    }
    next_block(bound);
  }
  /// The start where nothing fits anywhere.
  PARLOC_HD const SlamPose& pose() const { return best_; }

 private:
  struct Offset {
    std::int32_t i, j, turn;
  };

  /// Of pose k of a block.
  PARLOC_HD Offset offset(std::int32_t block, int k, const SearchRules& r) const {
    const std::int32_t turn = block / (along_ * along_) - r.turns, in = block % (along_ * along_);
    return {in % along_ * kBlock - r.cells + k % kBlock, in / along_ * kBlock - r.cells + k / kBlock, turn};
  }
  PARLOC_HD SlamPose pose(const Offset& o, const SearchRules& r) const {
    SlamPose p = start_;
    p.x += static_cast<float>(o.i) * r.resolution_m;
    p.y += static_cast<float>(o.j) * r.resolution_m;
    p.theta = wrap(p.theta + static_cast<float>(o.turn) * r.step_theta);
    return p;
  }
  PARLOC_HD std::int32_t bias(const Offset& o, const SearchRules& r) const {
    const float cells_sq = static_cast<float>(o.i * o.i + o.j * o.j);
    const float turns_sq = static_cast<float>(o.turn * o.turn);
    return static_cast<std::int32_t>(bias_ * (cells_sq * r.inv_cells_sq + turns_sq * r.inv_turns_sq));
  }
  PARLOC_HD std::int32_t least_bias(std::int32_t block, const SearchRules& r) const {
    const Offset low = offset(block, 0, r);
    const auto nearest = [](std::int32_t first) {
      return first > 0 ? first : first + kBlock > 0 ? 0 : first + kBlock - 1;
    };
    return bias({nearest(low.i), nearest(low.j), low.turn}, r);
  }
  /// The block with the largest bound, the first of equals; none beats the best pose: the search is done.
  PARLOC_HD void next_block(const std::int32_t* bound) {
    std::int32_t most = best_total_;
    block_ = -1;
    for (std::int32_t b = 0; b < blocks_; ++b)
      if (bound[b] > most) block_ = b, most = bound[b];
    done_ = block_ < 0 || looked_ == kMostLooked;
  }

  SlamPose start_, best_;
  std::int32_t best_total_ = 0, along_ = 0, blocks_ = 0, bounded_ = 0, block_ = -1;
  int looked_ = 0;
  float bias_ = 0;
  bool done_ = true;
};

/// Whether one of the cells from (i0, j0), 10 x 10 of them, is occupied: all cells that the end of a beam has
/// around it at any pose of a block.
PARLOC_HD bool occupied_near_block(const TileMap& map, std::int32_t i0, std::int32_t j0) {
  constexpr std::int32_t kSide = WideSearch::kBlock + 2;
  constexpr std::uint64_t kSideBits = (1u << kSide) - 1;
  const std::int32_t in_i = i0 & (kTileCells - 1);
  std::uint32_t found = 0;
  for (std::int32_t j = j0; j < j0 + kSide;) {
    const std::int32_t in_j = j & (kTileCells - 1);
    const std::int32_t rows = j0 + kSide - j < kTileCells - in_j ? j0 + kSide - j : kTileCells - in_j;
    const Tile& left = map.tile(i0, j);
    const Tile& right = in_i + kSide > kTileCells ? map.tile(i0 + kTileCells, j) : left;
    for (std::int32_t k = 0; k < rows; ++k) {
      const std::uint64_t row = (std::uint64_t{right.occupied[in_j + k]} << 32) | left.occupied[in_j + k];
      found |= static_cast<std::uint32_t>((row >> in_i) & kSideBits);
    }
    j += rows;
  }
  return found != 0;
}

/// One beam's part of a block's bound: no pose of the block scores more than the sum [1/65536]. `p`: its
/// first pose.
PARLOC_HD std::int32_t block_term(const TileMap& map, const Beams& b, std::size_t m, const MatchPose& p,
                                  const MatchRules& r) {
  if (b.range_m[m] > r.usable_m) return 0;
  const float u = fused(p.cos, b.end_x[m], fused(-p.sin, b.end_y[m], p.u));
  const float v = fused(p.sin, b.end_x[m], fused(p.cos, b.end_y[m], p.v));
  const std::int32_t i = static_cast<std::int32_t>(floor_of(u)), j = static_cast<std::int32_t>(floor_of(v));
  return occupied_near_block(map, i - 1, j - 1) ? static_cast<std::int32_t>(kScoreUnits) : 0;
}

}  // namespace parloc
