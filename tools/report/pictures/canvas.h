// A small picture to draw on: anti-aliased lines, discs and labels.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tools/report/pictures/png_writer.h"

namespace parloc::tools {

/// Red, green, blue; row 0 at the top. Coordinates are in pixels, (0, 0) the outer corner of the top left
/// pixel. What lies outside is clipped, at a cost that is bounded by the picture's size. Coordinates are
/// finite.
class Canvas {
 public:
  Canvas(std::int32_t width, std::int32_t height, Rgba background);

  /// Whatever the colour's alpha.
  void set(std::int32_t x, std::int32_t y, Rgba colour);
  /// Paints with the colour's alpha times `coverage` (0 to 1).
  void blend(std::int32_t x, std::int32_t y, Rgba colour, double coverage);
  /// A straight line with round ends.
  void line(double x0, double y0, double x1, double y1, double width, Rgba colour);
  void disc(double x, double y, double radius, Rgba colour);
  void rectangle(double x0, double y0, double x1, double y1, Rgba colour);
  /// Letters, digits and .,-[] from a 5 x 7 font, other characters as blanks; (x, y) is the top left
  /// corner.
  void text(std::int32_t x, std::int32_t y, std::string_view label, std::int32_t scale, Rgba colour);
  /// Copies `other` with its top left corner at (x, y).
  void paste(const Canvas& other, std::int32_t x, std::int32_t y);
  static std::int32_t text_width(std::string_view label, std::int32_t scale);
  static constexpr std::int32_t text_rows = 9;  ///< With the descenders, times the scale.

  std::int32_t width() const { return width_; }
  std::int32_t height() const { return height_; }
  const std::vector<std::uint8_t>& pixels() const { return pixels_; }

 private:
  std::uint8_t* at(std::int32_t x, std::int32_t y);

  std::int32_t width_, height_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace parloc::tools
