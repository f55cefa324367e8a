// Where and in which colour a picture is drawn: Okabe and Ito's colours, as in the HTML report.
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

inline constexpr Rgba estimate_colour = {0, 114, 178, 255};
inline constexpr Rgba truth_colour = {230, 159, 0, 255};
inline constexpr Rgba odometry_colour = {181, 80, 140, 255};
inline constexpr Rgba particle_colour = {0, 158, 115, 160};
inline constexpr Rgba robot_colour = {213, 94, 0, 255};
inline constexpr Rgba white = {255, 255, 255, 255}, ink = {25, 28, 32, 255};
inline constexpr Rgba unknown_colour = {223, 226, 229, 255};

inline constexpr std::int32_t line_px = 26, margin_px = 14;

}  // namespace parloc::tools
