// What closing loops (common/slam/loops/close_loops.h) says of its work.
#pragma once

#include <cstddef>

namespace parloc {

/// Pieces of the path, a few metres long each, that were compared with earlier ones.
struct LoopCounts {
  std::size_t tried = 0;    ///< Pairs of pieces that may lie in one place.
  std::size_t found = 0;    ///< Of them fitted well, and in one place only.
  std::size_t used = 0;     ///< Of these agreed with others and were held to; the rest was refused.
  double most_moved_m = 0;  ///< Greatest correction of a pose of the particle's path.
};

}  // namespace parloc
