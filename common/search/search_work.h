// What a search's work is counted in: the same on every machine, thread count and backend, so that where a
// slice of it ends is, too.
//
// Mostly beams are looked up for 64 neighbouring blocks, or for the 64 poses of a block, at once. What is
// saved because such a sum is given up early is counted all the same: the count is the most that the work can
// be. The constants say how many units each kind of work is worth, so that a unit of any kind takes about as
// long: 1 to 3 ns on one core.
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

constexpr std::int64_t kTurnedBeam = 3;      ///< A beam's offset at a heading.
constexpr std::int64_t kStripBeam = 2;       ///< A beam of 64 blocks of a row,
constexpr std::int64_t kNarrowBeam = 1;      ///< or of the 8 at most of a task that is no wider.
constexpr std::int64_t kBlockBeam = 3;       ///< A beam of the poses of a block: eight rows of the map.
constexpr std::int64_t kOtherBeams = 16;     ///< What else there is to do for 64 of either, in beams.
constexpr std::int64_t kSlots = 4;           ///< Champions cleared or looked through in a unit.
constexpr std::int64_t kSortedKey = 20;      ///< A champion put in order,
constexpr std::int64_t kTakenKey = 100;      ///< and taken out again, the best first.
constexpr std::int64_t kComparedPose = 2;    ///< Whether two poses are apart.
constexpr std::int64_t kFieldBeam = 3;       ///< A beam looked up between four cells.
constexpr std::int64_t kRay = 60;            ///< A beam cast to the map's walls, and judged.
constexpr std::int64_t kChancePlace = 9000;  ///< A random ray compared with every range.

}  // namespace search_work
}  // namespace parloc
