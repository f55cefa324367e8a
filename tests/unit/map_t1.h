// Test map T1 of the specification, on which its worked examples are.
#pragma once

#include "common/map/grid_map.h"

namespace parloc::test {

/// Section 0.2: 10 x 8 cells of 0.5 m, walls around, cells (6, 4) and (3, 2).
inline GridMap map_t1() {
  return grid_from_text({"##########",   //
                         "#........#",   //
                         "#........#",   //
                         "#.....#..#",   //
                         "#........#",   //
                         "#..#.....#",   //
                         "#........#",   //
                         "##########"},  //
                        0.5, {-1.0, -2.0, 0.0});
}

}  // namespace parloc::test
