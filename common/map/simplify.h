// Chains of points with fewer points.
#pragma once

#include <cstddef>
#include <vector>

namespace parloc {

struct ChainPoint {
  double x, y;
};

/// The points that remain, as rising indices; the first and the last always do.
struct SimplifiedChain {
  std::vector<std::size_t> kept;
  double error = 0.0;  ///< The largest distance of a point of the chain from the line that replaces it there.
};

/// Douglas and Peucker's method with distances to the line between its ends, not beyond them: then the chain
/// and its replacement are nowhere farther than `error`, at most `max_error`, from each other. A chain whose
/// ends are the same point keeps the point that is farthest from there too. `chain` has 2 points or more.
SimplifiedChain simplify(const std::vector<ChainPoint>& chain, double max_error);

}  // namespace parloc
