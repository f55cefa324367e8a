// A small picture to draw on: anti-aliased lines, discs and labels, by Cairo.
#pragma once

#include <cairo.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/report/pictures/pixel.h"
#include "tools/report/pictures/png_writer.h"

namespace parloc::tools {

/// Which point of a label lies at the given place; always at half the height of its capitals.
enum class Anchor { left, middle, right };

/// Coordinates are in pixels, (0, 0) the outer corner of the top left pixel. What lies outside is clipped, at
/// a cost that is bounded by the picture's size. Coordinates are finite. Labels are UTF-8 in the machine's
/// sans-serif font: their pixels differ between machines, all else is the same.
class Canvas {
 public:
  /// All white. Throws Error{internal} if there is no memory for so many pixels.
  Canvas(std::int32_t width, std::int32_t height);

  /// Every pixel of the upper left rectangle, whatever the colour's alpha.
  void paint(std::int32_t width, std::int32_t height,
             const std::function<Rgba(std::int32_t x, std::int32_t y)>& colour_of);
  /// Joined straight lines with round ends; a single point is a disc. Dashes and gaps are `dash_px` long, if
  /// that is not 0.
  void line(const std::vector<Pixel>& points, double width, Rgba colour, double dash_px = 0.0);
  void polygon(const std::vector<Pixel>& corners, Rgba colour);
  void disc(Pixel centre, double radius, Rgba colour);
  void rectangle(double x0, double y0, double x1, double y1, Rgba colour);
  void text(Pixel at, const std::string& label, Rgba colour, Anchor anchor = Anchor::left);
  double text_width(const std::string& label) const;

  /// What is drawn by `draw` is cut off outside the rectangle.
  void clipped(double x0, double y0, double x1, double y1, const std::function<void()>& draw);

  std::int32_t width() const { return width_; }
  std::int32_t height() const { return height_; }
  /// The bytes of a PNG file. Throws Error{internal} if anything could not be drawn.
  std::string png(PngEffort effort = PngEffort::small) const;

 private:
  void outline(const std::vector<Pixel>& points);
  void fill(Rgba colour);

  std::int32_t width_, height_;
  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface_;
  std::unique_ptr<cairo_t, void (*)(cairo_t*)> cairo_;
};

}  // namespace parloc::tools
