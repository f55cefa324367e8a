#include "common/map/trace_walls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/error.h"
#include "common/map/grid_map.h"
#include "common/map/simplify.h"

namespace parloc {
namespace {

/// A corner of cells: (i, j) is the lower-left one of cell (i, j).
struct Corner {
  std::int32_t x, y;
};

/// 0 to 3: along +x, +y, -x, -y. A wall is followed with what blocks on its left.
using Direction = int;
constexpr std::int32_t kStepX[4] = {1, 0, -1, 0}, kStepY[4] = {0, 1, 0, -1};

/// Walks along the faces of blocking cells.
class FaceWalk {
 public:
  FaceWalk(const GridMap& map, bool unknown_blocks)
      : width_(map.width), height_(map.height), cells_(blocking_cells(map, unknown_blocks)) {}

  /// Calls take(corners) once for each chain of faces: the corners where it turns, the first one again at the
  /// end if it closes.
  template <class Take>
  void for_each_chain(Take&& take) {
    const auto try_at = [&](Corner from, Direction d) {
      if (is_new_face(from, d)) take(follow(from, d));
    };
    for (std::int32_t x = 1; x < width_; ++x) try_at({x, 0}, 1), try_at({x, height_}, 3);  // from the rim
    for (std::int32_t y = 1; y < height_; ++y) try_at({0, y}, 0), try_at({width_, y}, 2);
    // Each other chain closes, and so has faces below cells. The first in this order is at a turn.
    for (std::int32_t y = 1; y < height_; ++y) {
      for (std::int32_t x = 0; x < width_; ++x) try_at({x, y}, 0);
    }
  }

 private:
  /// The cell on the left of the face that leaves a corner in a direction, and the one on its right.
  std::size_t left(Corner c, Direction d) const { return cell(c.x - (d == 1 || d == 2), c.y - (d >= 2)); }
  std::size_t right(Corner c, Direction d) const { return cell(c.x - (d >= 2), c.y - (d == 0 || d == 3)); }
  std::size_t cell(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i);
  }
  bool blocks(std::size_t c) const { return (cells_[c] & 1) != 0; }
  bool on_rim(Corner c) const { return c.x == 0 || c.y == 0 || c.x == width_ || c.y == height_; }
  static std::uint8_t seen_bit(Direction d) { return static_cast<std::uint8_t>(2 << d); }

  bool is_new_face(Corner c, Direction d) const {
    return blocks(left(c, d)) && !blocks(right(c, d)) && (cells_[left(c, d)] & seen_bit(d)) == 0;
  }

  std::vector<ChainPoint> follow(Corner at, Direction d) {
    std::vector<ChainPoint> corners{{static_cast<double>(at.x), static_cast<double>(at.y)}};
    for (;;) {
      cells_[left(at, d)] |= seen_bit(d);
      at.x += kStepX[d], at.y += kStepY[d];
      Direction next = d;
      if (!on_rim(at)) next = blocks(right(at, d)) ? (d + 3) % 4 : blocks(left(at, d)) ? d : (d + 1) % 4;
      const bool ends = on_rim(at) || (cells_[left(at, next)] & seen_bit(next)) != 0;
      if (ends || next != d) corners.push_back({static_cast<double>(at.x), static_cast<double>(at.y)});
      if (ends) return corners;
      d = next;
    }
  }

  std::int32_t width_, height_;
  std::vector<std::uint8_t> cells_;  ///< Bit 0: blocks. Bits 1 to 4: its face in direction 0 to 3 was passed.
};

void add_chain(TracedWalls& traced, const std::vector<ChainPoint>& corners, double max_error_m,
               double resolution_m) {
  traced.faces += corners.size() - 1;
  const SimplifiedChain chain = simplify(corners, max_error_m / resolution_m);
  const auto coordinate = [&](double cells) { return static_cast<float>(cells * resolution_m); };
  const bool to_and_fro = chain.kept.size() == 3 && corners.front().x == corners.back().x &&
                          corners.front().y == corners.back().y;
  for (std::size_t k = 1; k < chain.kept.size() - (to_and_fro ? 1 : 0); ++k) {
    const ChainPoint &a = corners[chain.kept[k - 1]], &b = corners[chain.kept[k]];
    traced.walls.push_back({coordinate(a.x), coordinate(a.y), coordinate(b.x), coordinate(b.y)});
  }
  traced.error_m = std::max(traced.error_m, chain.error * resolution_m);
}

}  // namespace

TracedWalls trace_walls(const GridMap& map, double max_error_m, bool unknown_blocks) {
  if (!(max_error_m >= 0.0 && std::isfinite(max_error_m))) {
    throw Error(ErrorKind::usage,
                fmt::format("the largest error of walls must be 0 m or more, got {}", max_error_m));
  }
  TracedWalls traced;
  FaceWalk(map, unknown_blocks).for_each_chain([&](const std::vector<ChainPoint>& corners) {
    add_chain(traced, corners, max_error_m, map.resolution_m);
  });
  return traced;
}

}  // namespace parloc
