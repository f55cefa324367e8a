#include "tools/report/pictures/canvas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "common/error.h"

namespace parloc::tools {
namespace {

constexpr double kFont_px = 17.0;

/// Cairo keeps coordinates in 32 bits with 8 of them behind the point. A point that is farther away than any
/// picture is wide is drawn nearer, in its direction.
Pixel in_reach(Pixel p) {
  constexpr double kFar_px = 1e6;
  const double far = std::max(std::abs(p.x), std::abs(p.y));
  return far > kFar_px ? Pixel{p.x * kFar_px / far, p.y * kFar_px / far} : p;
}

void set_colour(cairo_t* cairo, Rgba colour) {
  cairo_set_source_rgba(cairo, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0,
                        colour.alpha / 255.0);
}

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ErrorKind::internal, std::string("picture: ") + cairo_status_to_string(status));
}

}  // namespace

Canvas::Canvas(std::int32_t width, std::int32_t height)
    : width_(width),
      height_(height),
      surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy),
      cairo_(cairo_create(surface_.get()), cairo_destroy) {
  check(cairo_status(cairo_.get()));
  cairo_set_source_rgb(cairo_.get(), 1.0, 1.0, 1.0);
  cairo_paint(cairo_.get());
  cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
  cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo_.get(), kFont_px);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);  // no coloured fringes
  cairo_set_font_options(cairo_.get(), options);
  cairo_font_options_destroy(options);
}

void Canvas::paint(std::int32_t width, std::int32_t height,
                   const std::function<Rgba(std::int32_t x, std::int32_t y)>& colour_of) {
  cairo_surface_flush(surface_.get());
  unsigned char* data = cairo_image_surface_get_data(surface_.get());
  const int stride = cairo_image_surface_get_stride(surface_.get());
  for (std::int32_t y = 0; y < std::min(height, height_); ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
    for (std::int32_t x = 0; x < std::min(width, width_); ++x) {
      const Rgba c = colour_of(x, y);
      row[x] = std::uint32_t{c.red} << 16 | std::uint32_t{c.green} << 8 | c.blue;
    }
  }
  cairo_surface_mark_dirty(surface_.get());
}

void Canvas::outline(const std::vector<Pixel>& points) {
  cairo_new_path(cairo_.get());
  for (const Pixel& point : points) {
    const Pixel p = in_reach(point);
    cairo_line_to(cairo_.get(), p.x, p.y);
  }
}

void Canvas::fill(Rgba colour) {
  set_colour(cairo_.get(), colour);
  cairo_fill(cairo_.get());
}

void Canvas::line(const std::vector<Pixel>& points, double width, Rgba colour, double dash_px) {
  outline(points);
  if (points.size() == 1) cairo_close_path(cairo_.get());  // else Cairo draws nothing
  cairo_set_line_width(cairo_.get(), width);
  cairo_set_dash(cairo_.get(), &dash_px, dash_px > 0.0 ? 1 : 0, 0.0);
  set_colour(cairo_.get(), colour);
  cairo_stroke(cairo_.get());
}

void Canvas::polygon(const std::vector<Pixel>& corners, Rgba colour) {
  outline(corners);
  fill(colour);
}

void Canvas::disc(Pixel centre, double radius, Rgba colour) {
  const Pixel c = in_reach(centre);
  cairo_new_path(cairo_.get());
  cairo_arc(cairo_.get(), c.x, c.y, radius, 0.0, 2.0 * std::numbers::pi);
  fill(colour);
}

void Canvas::rectangle(double x0, double y0, double x1, double y1, Rgba colour) {
  polygon({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, colour);
}

void Canvas::text(Pixel at, const std::string& label, Rgba colour, Anchor anchor) {
  const double share = anchor == Anchor::left ? 0.0 : anchor == Anchor::middle ? 0.5 : 1.0;
  cairo_text_extents_t capital;
  cairo_text_extents(cairo_.get(), "H", &capital);
  cairo_new_path(cairo_.get());
  cairo_move_to(cairo_.get(), std::round(at.x - share * text_width(label)),
                std::round(at.y + 0.5 * capital.height));
  set_colour(cairo_.get(), colour);
  cairo_show_text(cairo_.get(), label.c_str());
}

double Canvas::text_width(const std::string& label) const {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_.get(), label.c_str(), &extents);
  return extents.x_advance;
}

void Canvas::clipped(double x0, double y0, double x1, double y1, const std::function<void()>& draw) {
  cairo_save(cairo_.get());
  cairo_rectangle(cairo_.get(), x0, y0, x1 - x0, y1 - y0);
  cairo_clip(cairo_.get());
  draw();
  cairo_restore(cairo_.get());
}

std::string Canvas::png(PngEffort effort) const {
  check(cairo_status(cairo_.get()));
  cairo_surface_flush(surface_.get());
  const unsigned char* data = cairo_image_surface_get_data(surface_.get());
  const int stride = cairo_image_surface_get_stride(surface_.get());
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (std::int32_t y = 0; y < height_; ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
    for (std::int32_t x = 0; x < width_; ++x)
      for (const int shift : {16, 8, 0}) rgb.push_back(static_cast<std::uint8_t>(row[x] >> shift));
  }
  return encode_png_rgb(width_, height_, rgb, effort);
}

}  // namespace parloc::tools
