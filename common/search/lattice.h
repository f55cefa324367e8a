// The lattice of poses that a global search goes through, and its bounds. The arithmetic that
// cpu/global_search.cpp and cuda/global_search.cu loop over; integers only.
//
// A lattice pose is the centre of a cell (i, j) and one of K headings. The end point of beam b then lies in
// the cell (i, j) + offset[k][b]. A cell is worth 0 (far from walls) to kMostValue (on a wall), nothing off
// the map, and a pose the sum over its beams. For blocks of 8 x 8 cells there is the largest value of the 8 x
// 8 window that begins at each cell: a sum of these is at least the score of every pose of the block.
#pragma once

#include <cstdint>

#include "common/math/atomics.h"
#include "common/math/host_device.h"

namespace parloc {

constexpr int kBlockBits = 3;
constexpr std::int32_t kBlockCells = 1 << kBlockBits;  ///< Along a side.
constexpr std::int32_t kBlockPoses = kBlockCells * kBlockCells;

/// Four of them fit in a byte: that is what the vector loop of the CPU lives on.
constexpr std::uint32_t kMostValue = 63;

/// Zeros on both sides of a row of windows: as many as are read at once.
constexpr std::int32_t kSweepLanes = 64;

/// Directions are put together in this many bins when the best pose of a place is kept.
constexpr std::int32_t kTurnBins = 36;

/// Rows of bytes with zeros around them.
struct SearchPlane {
  const std::uint8_t* first = nullptr;  ///< Entry (0, 0).
  std::int32_t width = 0, height = 0;
  std::int32_t stride = 0;  ///< From row to row.
};

/// What a search needs of a map, in the backend's memory.
struct SearchGrid {
  std::int32_t width = 0, height = 0;  ///< [cells]
  /// Values by cell; kBlockCells zeros all around.
  SearchPlane cells;
  /// Plane (0, 0) of the windows' maxima, split by phase: that of the window at x = 8 q + r, y likewise, is
  /// entry q + 1 of plane r, so that what neighbouring blocks look up lies side by side. q begins at -1,
  /// where windows reach into the map. kSweepLanes zeros to the left and right, a row of zeros above and
  /// below.
  SearchPlane windows;
  std::int64_t plane = 0;                    ///< From plane to plane; row-major by phase.
  const std::uint8_t* free_cells = nullptr;  ///< Row-major: whether a robot can be there.
  const std::uint8_t* free_blocks = nullptr;

  PARLOC_HD std::int32_t blocks_x() const { return (width + kBlockCells - 1) >> kBlockBits; }
  PARLOC_HD std::int32_t blocks_y() const { return (height + kBlockCells - 1) >> kBlockBits; }
  PARLOC_HD bool is_free(std::int32_t i, std::int32_t j) const {
    return free_cells[std::int64_t{j} * width + i] != 0;
  }
};

struct Offset {
  std::int32_t x, y;  ///< [cells]
};

/// Cells whose centres lie in a disc, in half cells: exact.
struct DiscOfCells {
  std::int64_t x = 0, y = 0;         ///< [half cells]
  std::int64_t squared_radius = -1;  ///< Below 0: everywhere.
  PARLOC_HD bool contains(std::int32_t i, std::int32_t j) const {
    const std::int64_t dx = 2 * std::int64_t{i} + 1 - x, dy = 2 * std::int64_t{j} + 1 - y;
    return squared_radius < 0 || dx * dx + dy * dy <= squared_radius;
  }
};

/// One search.
struct SearchTask {
  SearchGrid grid;
  const Offset* offsets = nullptr;  ///< [headings][beams], in the backend's memory.
  std::int32_t beams = 0, headings = 0;
  std::int32_t first_heading = 0, heading_count = 0;  ///< Those asked for; beyond the last comes the first.
  std::int32_t block_i = 0, block_j = 0, block_end_i = 0, block_end_j = 0;
  DiscOfCells region;
  std::uint32_t least = 0;         ///< Scores below it are of no interest,
  std::uint32_t share_1024th = 0;  ///< nor those below this share of the best.

  PARLOC_HD std::int32_t heading(std::int32_t k) const { return (first_heading + k) % headings; }
  PARLOC_HD std::uint32_t threshold(std::uint32_t best) const {
    const std::uint32_t share = (best * share_1024th + 1023) / 1024;
    return share > least ? share : least;
  }
};

/// What a search finds, in the backend's memory: integers, raised in any order.
struct SearchFinds {
  std::uint32_t* best = nullptr;
  std::uint64_t* champion = nullptr;  ///< By block and heading bin the best pose, as pose_key; 0: none.
};

/// Orders poses: by score, the first on the lattice among equals.
constexpr std::uint64_t kLastPose = (std::uint64_t{1} << 40) - 1;
PARLOC_HD std::uint64_t pose_key(const SearchGrid& g, std::int32_t k, std::int32_t i, std::int32_t j,
                                 std::uint32_t score) {
  const std::uint64_t index =
      (static_cast<std::uint64_t>(k) * static_cast<std::uint64_t>(g.height) + static_cast<std::uint64_t>(j)) *
          static_cast<std::uint64_t>(g.width) +
      static_cast<std::uint64_t>(i);
  return (std::uint64_t{score} << 40) | (kLastPose - index);
}

/// Value of the cell that pose (i, j) sees by a beam.
PARLOC_HD std::uint32_t cell_value(const SearchGrid& g, std::int32_t i, std::int32_t j, Offset o) {
  const std::int32_t x = i + o.x, y = j + o.y;
  if (x < 0 || y < 0 || x >= g.width || y >= g.height) return 0;
  return g.cells.first[std::int64_t{y} * g.cells.stride + x];
}

/// Plane of the windows that blocks see by a beam, and where in it, from a block's own place.
PARLOC_HD const std::uint8_t* plane_of(const SearchGrid& g, Offset o) {
  constexpr std::int32_t mask = kBlockCells - 1;
  return g.windows.first + (((o.y & mask) << kBlockBits) + (o.x & mask)) * g.plane;
}
PARLOC_HD Offset entry_of(Offset o) {
  return {(o.x >> kBlockBits) + 1, (o.y >> kBlockBits) + 1};
}

/// The most that a pose of block (i, j) sees by a beam.
PARLOC_HD std::uint32_t window_value(const SearchGrid& g, std::int32_t i, std::int32_t j, Offset o) {
  const Offset at = entry_of(o);
  const std::int32_t x = i + at.x, y = j + at.y;
  if (x < 0 || y < 0 || x >= g.windows.width || y >= g.windows.height) return 0;
  return plane_of(g, o)[std::int64_t{y} * g.windows.stride + x];
}

/// A sum over the beams of heading k, or 0 as soon as it cannot reach `least`.
template <class Value>
PARLOC_HD std::uint32_t sum_of_beams(const SearchTask& t, std::int32_t k, std::uint32_t least,
                                     const Value& value) {
  const Offset* offset = t.offsets + std::int64_t{k} * t.beams;
  std::uint32_t sum = 0;
  std::int32_t b = 0;
  while (b < t.beams) {
    const std::int32_t stop = b + 8 < t.beams ? b + 8 : t.beams;
    for (; b < stop; ++b) sum += value(offset[b]);
    if (sum + kMostValue * static_cast<std::uint32_t>(t.beams - b) < least) return 0;
  }
  return sum;
}

PARLOC_HD std::uint32_t score_of_pose(const SearchTask& t, std::int32_t k, std::int32_t i, std::int32_t j,
                                      std::uint32_t least) {
  return sum_of_beams(t, k, least, [&](Offset o) { return cell_value(t.grid, i, j, o); });
}

PARLOC_HD std::uint32_t bound_of_block(const SearchTask& t, std::int32_t k, std::int32_t block_i,
                                       std::int32_t block_j, std::uint32_t least) {
  return sum_of_beams(t, k, least, [&](Offset o) { return window_value(t.grid, block_i, block_j, o); });
}

/// Where the best pose of a block and heading bin is kept.
PARLOC_HD std::int64_t champion_slot(const SearchTask& t, std::int32_t k, std::int32_t block_i,
                                     std::int32_t block_j) {
  const std::int64_t block = std::int64_t{block_j} * t.grid.blocks_x() + block_i;
  return block * kTurnBins + std::int64_t{k} * kTurnBins / t.headings;
}

/// What is left out is below the threshold of a score that some pose has, hence below the final one: the
/// order of the work changes its amount, never what is found.
PARLOC_HD void record_pose(const SearchTask& t, const SearchFinds& finds, std::int32_t k, std::int32_t i,
                           std::int32_t j, std::uint32_t score) {
  atomic_raise(finds.best, score);
  atomic_raise(finds.champion + champion_slot(t, k, i >> kBlockBits, j >> kBlockBits),
               pose_key(t.grid, k, i, j, score));
}

/// Whether a cell of a block is one where the robot may be.
PARLOC_HD bool pose_counts(const SearchTask& t, std::int32_t i, std::int32_t j) {
  return i < t.grid.width && j < t.grid.height && t.grid.is_free(i, j) && t.region.contains(i, j);
}

/// For a first good score: only every so manieth heading is swept, and the best block of each is searched for
/// the headings around.
constexpr std::int32_t kDiveStep = 8;

/// Orders blocks by their bound; the first among equals.
PARLOC_HD std::uint64_t block_key(std::uint32_t bound, std::uint32_t block) {
  return (std::uint64_t{bound} << 32) | (0xffffffffu - block);
}
PARLOC_HD std::uint32_t block_of_key(std::uint64_t key) {
  return 0xffffffffu - static_cast<std::uint32_t>(key);
}

}  // namespace parloc
