#include "common/map/simplify.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace parloc {
namespace {

double distance(const ChainPoint& p, const ChainPoint& a, const ChainPoint& b) {
  const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
  const double along =
      square > 0.0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  const double u = p.x - a.x - along * dx, v = p.y - a.y - along * dy;
  return std::sqrt(u * u + v * v);
}

struct Farthest {
  std::size_t index;
  double distance;
};

/// Of the points between `first` and `last`, from the line between these two.
Farthest farthest(const std::vector<ChainPoint>& chain, std::size_t first, std::size_t last) {
  Farthest found = {first, 0.0};
  for (std::size_t k = first + 1; k < last; ++k) {
    const double d = distance(chain[k], chain[first], chain[last]);
    if (d > found.distance) found = {k, d};
  }
  return found;
}

}  // namespace

SimplifiedChain simplify(const std::vector<ChainPoint>& chain, double max_error) {
  SimplifiedChain result;
  const bool closed = chain.front().x == chain.back().x && chain.front().y == chain.back().y;
  result.kept.push_back(0);
  std::vector<std::size_t> ends{chain.size() - 1};  // of the parts that are still to do, the nearest on top
  if (closed) {
    const std::size_t opposite = farthest(chain, 0, chain.size() - 1).index;
    if (opposite > 0) ends.push_back(opposite);
  }
  while (!ends.empty()) {
    const Farthest worst = farthest(chain, result.kept.back(), ends.back());
    if (worst.distance > max_error) {
      ends.push_back(worst.index);
      continue;
    }
    result.error = std::max(result.error, worst.distance);
    result.kept.push_back(ends.back());
    ends.pop_back();
  }
  return result;
}

}  // namespace parloc
