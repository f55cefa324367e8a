#include "tools/report/pictures/canvas.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>

namespace parloc::tools {
namespace {

/// Rows of a glyph from the top; bit 4 is the left column. Rows 7 and 8 hold descenders.
struct Glyph {
  char character;
  std::uint8_t rows[9];
};

// clang-format off
constexpr Glyph font[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},     {'2', {14, 17, 1, 6, 8, 16, 31}},
    {'3', {14, 17, 1, 6, 1, 17, 14}},    {'4', {2, 6, 10, 18, 31, 2, 2}},    {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},      {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},   {'.', {0, 0, 0, 0, 0, 12, 12}},     {'-', {0, 0, 0, 14, 0, 0, 0}},
    {',', {0, 0, 0, 0, 0, 12, 12, 4, 8}}, {'[', {14, 8, 8, 8, 8, 8, 14}},    {']', {14, 2, 2, 2, 2, 2, 14}},
    {'a', {0, 0, 14, 1, 15, 17, 15}},    {'b', {16, 16, 30, 17, 17, 17, 30}}, {'c', {0, 0, 14, 17, 16, 17, 14}},
    {'d', {1, 1, 15, 17, 17, 17, 15}},   {'e', {0, 0, 14, 17, 31, 16, 14}},  {'f', {6, 8, 28, 8, 8, 8, 8}},
    {'g', {0, 0, 15, 17, 17, 17, 15, 1, 14}}, {'h', {16, 16, 30, 17, 17, 17, 17}}, {'i', {4, 0, 12, 4, 4, 4, 14}},
    {'j', {2, 0, 6, 2, 2, 2, 2, 18, 12}}, {'k', {16, 16, 18, 20, 24, 20, 18}}, {'l', {12, 4, 4, 4, 4, 4, 14}},
    {'m', {0, 0, 26, 21, 21, 21, 21}},   {'n', {0, 0, 30, 17, 17, 17, 17}},  {'o', {0, 0, 14, 17, 17, 17, 14}},
    {'p', {0, 0, 30, 17, 17, 17, 30, 16, 16}}, {'q', {0, 0, 15, 17, 17, 17, 15, 1, 1}}, {'r', {0, 0, 22, 25, 16, 16, 16}},
    {'s', {0, 0, 15, 16, 14, 1, 30}},    {'t', {8, 8, 28, 8, 8, 9, 6}},      {'u', {0, 0, 17, 17, 17, 19, 13}},
    {'v', {0, 0, 17, 17, 17, 10, 4}},    {'w', {0, 0, 17, 17, 21, 21, 10}},  {'x', {0, 0, 17, 10, 4, 10, 17}},
    {'y', {0, 0, 17, 17, 17, 17, 15, 1, 14}}, {'z', {0, 0, 31, 2, 4, 8, 31}},
};
// clang-format on
constexpr std::int32_t glyph_advance = 6;

const Glyph* glyph_of(char c) {
  const char lower = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto* found =
      std::find_if(std::begin(font), std::end(font), [&](const Glyph& g) { return g.character == lower; });
  return found == std::end(font) ? nullptr : found;
}

/// Pixels from `low` to `high`, cut to 0 .. limit - 1.
struct Range {
  std::int32_t begin, end;
};
Range pixel_range(double low, double high, std::int32_t limit) {
  const double most = limit;
  return {static_cast<std::int32_t>(std::floor(std::clamp(low, 0.0, most))),
          static_cast<std::int32_t>(std::ceil(std::clamp(high, 0.0, most)))};
}

}  // namespace

Canvas::Canvas(std::int32_t width, std::int32_t height, Rgba background)
    : width_(width),
      height_(height),
      pixels_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) set(x, y, background);
  }
}

void Canvas::set(std::int32_t x, std::int32_t y, Rgba colour) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  std::uint8_t* p = at(x, y);
  p[0] = colour.red, p[1] = colour.green, p[2] = colour.blue;
}

std::uint8_t* Canvas::at(std::int32_t x, std::int32_t y) {
  return &pixels_[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(x))];
}

void Canvas::blend(std::int32_t x, std::int32_t y, Rgba colour, double coverage) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  const double share = std::clamp(coverage * colour.alpha / 255.0, 0.0, 1.0);
  std::uint8_t* p = at(x, y);
  const std::uint8_t target[3] = {colour.red, colour.green, colour.blue};
  for (int k = 0; k < 3; ++k)
    p[k] = static_cast<std::uint8_t>(std::lround(p[k] + share * (target[k] - p[k])));
}

void Canvas::line(double x0, double y0, double x1, double y1, double width, Rgba colour) {
  const double dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
  const double reach = 0.5 * width + 0.5;
  const Range rows = pixel_range(std::min(y0, y1) - reach, std::max(y0, y1) + reach, height_);
  for (std::int32_t row = rows.begin; row < rows.end; ++row) {
    double low = std::min(x0, x1), high = std::max(x0, x1);
    if (std::abs(dy) > 1e-9) {  // only the part of the row near the line, so that a long line costs its area
      const double middle = x0 + (row + 0.5 - y0) * dx / dy;
      const double half = (reach + 1.0) * std::sqrt(square) / std::abs(dy);
      low = std::max(low, middle - half), high = std::min(high, middle + half);
    }
    const Range columns = pixel_range(low - reach, high + reach, width_);
    for (std::int32_t column = columns.begin; column < columns.end; ++column) {
      const double px = column + 0.5 - x0, py = row + 0.5 - y0;
      const double along = square > 0.0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0.0;
      const double distance = std::hypot(px - along * dx, py - along * dy);
      if (distance < reach) blend(column, row, colour, std::min(1.0, reach - distance));
    }
  }
}

void Canvas::disc(double x, double y, double radius, Rgba colour) {
  line(x, y, x, y, 2 * radius, colour);
}

void Canvas::rectangle(double x0, double y0, double x1, double y1, Rgba colour) {
  const Range rows = pixel_range(y0, y1, height_), columns = pixel_range(x0, x1, width_);
  for (std::int32_t row = rows.begin; row < rows.end; ++row) {
    for (std::int32_t column = columns.begin; column < columns.end; ++column) blend(column, row, colour, 1.0);
  }
}

void Canvas::text(std::int32_t x, std::int32_t y, std::string_view label, std::int32_t scale, Rgba colour) {
  for (const char c : label) {
    const Glyph* glyph = glyph_of(c);
    for (std::int32_t row = 0; glyph != nullptr && row < text_rows; ++row) {
      for (std::int32_t column = 0; column < 5; ++column) {
        if ((glyph->rows[row] >> (4 - column) & 1) == 0) continue;
        const std::int32_t left = x + column * scale, top = y + row * scale;
        rectangle(left, top, left + scale, top + scale, colour);
      }
    }
    x += glyph_advance * scale;
  }
}

void Canvas::paste(const Canvas& other, std::int32_t x, std::int32_t y) {
  const std::uint8_t* p = other.pixels_.data();
  for (std::int32_t row = 0; row < other.height_; ++row) {
    for (std::int32_t column = 0; column < other.width_; ++column, p += 3)
      set(x + column, y + row, {p[0], p[1], p[2], 255});
  }
}

std::int32_t Canvas::text_width(std::string_view label, std::int32_t scale) {
  return static_cast<std::int32_t>(label.size()) * glyph_advance * scale - scale;
}

}  // namespace parloc::tools
