// What a search's work is counted in: the same on every machine, thread count and backend, so that where a
// slice of it ends is, too.
//
// One unit is one beam looked up for 64 neighbouring blocks, or for the 64 poses of a block: about 1 to 3 ns
// on one core. What is saved because a sum is given up early is counted all the same: the count is the most
// that the work can be. The rest is counted in what takes as long as a unit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace parloc {

/// Things of a list that are done one after the other: from `first` on so many.
struct SearchItems {
  std::size_t first = 0, count = 0;
  std::size_t end() const { return first + count; }
};

namespace search_work {

constexpr std::int64_t kTurnedBeam = 4;    ///< A beam's offset at a heading.
constexpr std::int64_t kBlockBeam = 3;     ///< A beam of a block's poses: eight rows of the map.
constexpr std::int64_t kSlots = 4;         ///< Champions cleared or looked through in a unit.
constexpr std::int64_t kSortedKey = 20;    ///< A champion put in order,
constexpr std::int64_t kTakenKey = 100;    ///< and taken out again, the best first.
constexpr std::int64_t kComparedPose = 2;  ///< Whether two poses are apart.
constexpr std::int64_t kFieldBeam = 5;     ///< A beam looked up between four cells.
constexpr std::int64_t kRay = 60;
constexpr std::int64_t kChancePlace = 4000;  ///< A random ray compared with every range.

}  // namespace search_work
}  // namespace parloc
