// A straight piece of wall.
#pragma once

namespace parloc {

/// From a to b in the grid frame of its map [m]. Closed: a ray that meets an end point is stopped.
struct GridWall {
  float ax, ay, bx, by;
};

}  // namespace parloc
