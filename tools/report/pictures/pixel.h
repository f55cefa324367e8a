// Where and in which colour a picture is drawn.
#pragma once

#include <cstdint>

namespace parloc::tools {

struct Pixel {
  double x = 0.0;  ///< Right, 0 at the left edge.
  double y = 0.0;  ///< Down, 0 at the top edge.
};

struct Rgba {
  std::uint8_t red = 0, green = 0, blue = 0, alpha = 255;
};

}  // namespace parloc::tools
