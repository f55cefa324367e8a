#include "tools/learn/learn_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/file/output_file.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t kWidth_px = 1000, kHeight_px = 440, kLeft_px = 90, kTop_px = 60;
constexpr int kBins = 250;
constexpr double kSpan_m = 2.5;                   // on either side
constexpr double kLowest = -4.0, kHighest = 1.5;  // powers of ten of the density
constexpr std::int32_t kGlyph_px = 7 * text_scale;
constexpr Rgba grid_colour = {216, 221, 227, 255}, soft = {91, 101, 112, 255};

using Densities = std::array<double, kBins>;

double bin_middle_m(int bin) {
  return kSpan_m * (2.0 * (bin + 0.5) / kBins - 1.0);
}

/// The beams that the plot is about.
std::vector<RangePair> on_walls(const RangePairs& ranges) {
  std::vector<RangePair> kept;
  for (const RangePair& p : ranges.pairs)
    if (p.measured_m < ranges.range_max_m && p.expected_m < ranges.range_max_m) kept.push_back(p);
  return kept;
}

Densities measured(const std::vector<RangePair>& pairs) {
  Densities d{};
  for (const RangePair& p : pairs) {
    const double place = (p.measured_m - p.expected_m + kSpan_m) / (2 * kSpan_m) * kBins;
    if (place >= 0 && place < kBins) d[static_cast<std::size_t>(place)] += 1.0;
  }
  for (double& v : d) v /= static_cast<double>(pairs.size()) * 2 * kSpan_m / kBins;
  return d;
}

/// For the same expected ranges (every so many of them), given that the beam hit something.
Densities fitted(const std::vector<RangePair>& pairs, const Mixture& m, double range_max_m) {
  Densities d{};
  const std::size_t step = std::max<std::size_t>(pairs.size() / 3000, 1);
  double used = 0.0;
  for (std::size_t k = 0; k < pairs.size(); k += step, used += 1.0) {
    const float expected_m = pairs[k].expected_m;
    const double hits =
        1.0 - mixture_likelihood(m, {static_cast<float>(range_max_m), expected_m}, range_max_m);
    for (int bin = 0; bin < kBins; ++bin) {
      const double range_m = expected_m + bin_middle_m(bin);
      if (range_m > 0.0 && range_m < range_max_m)
        d[static_cast<std::size_t>(bin)] +=
            mixture_likelihood(m, {static_cast<float>(range_m), expected_m}, range_max_m) / hits;
    }
  }
  for (double& v : d) v /= used;
  return d;
}

double column(double offset_m) {
  return kLeft_px + kWidth_px * (offset_m + kSpan_m) / (2 * kSpan_m);
}
double row(double density) {
  const double power = std::clamp(std::log10(std::max(density, 1e-30)), kLowest, kHighest);
  return kTop_px + kHeight_px * (kHighest - power) / (kHighest - kLowest);
}

void draw_grid(Canvas& canvas) {
  canvas.rectangle(kLeft_px, kTop_px, kLeft_px + kWidth_px, kTop_px + kHeight_px, {245, 247, 249, 255});
  const char* powers[] = {"0.0001", "0.001", "0.01", "0.1", "1", "10"};
  for (int k = 0; k < 6; ++k) {
    const double y = std::floor(row(std::pow(10.0, k - 4)));
    canvas.rectangle(kLeft_px, y, kLeft_px + kWidth_px, y + 1, grid_colour);
    canvas.text(kLeft_px - margin_px / 2 - Canvas::text_width(powers[k], text_scale),
                static_cast<std::int32_t>(y) - kGlyph_px / 2, powers[k], text_scale, soft);
  }
  for (int half = -5; half <= 5; ++half) {
    const double x = std::floor(column(0.5 * half));
    canvas.rectangle(x, kTop_px, x + 1, kTop_px + kHeight_px, grid_colour);
    const std::string label = fmt::format("{:g}", 0.5 * half);
    canvas.text(static_cast<std::int32_t>(x) - Canvas::text_width(label, text_scale) / 2,
                kTop_px + kHeight_px + margin_px, label, text_scale, soft);
  }
  const char* title = "measured minus expected range [m], density [1 per m]";
  canvas.text(kLeft_px, kTop_px - line_px, title, text_scale, ink);
}

void draw_key(Canvas& canvas) {
  const std::int32_t middle = kTop_px + kHeight_px + 2 * line_px, text_top = middle - kGlyph_px / 2;
  canvas.rectangle(kLeft_px, middle - 8, kLeft_px + 34, middle + 8, particle_colour);
  canvas.text(kLeft_px + 48, text_top, "measured", text_scale, ink);
  const std::int32_t next = kLeft_px + 48 + Canvas::text_width("measured", text_scale) + 2 * margin_px;
  canvas.line(next, middle, next + 34, middle, 3, estimate_colour);
  canvas.text(next + 48, text_top, "fitted mixture", text_scale, ink);
}

}  // namespace

void write_mixture_picture(const std::string& path, const RangePairs& ranges, const Mixture& mixture) {
  const std::vector<RangePair> pairs = on_walls(ranges);
  Canvas canvas(kLeft_px + kWidth_px + 40, kTop_px + kHeight_px + 3 * line_px + margin_px, white);
  draw_grid(canvas);
  if (!pairs.empty()) {
    const Densities bars = measured(pairs), curve = fitted(pairs, mixture, ranges.range_max_m);
    const double half_m = kSpan_m / kBins;
    for (int bin = 0; bin < kBins; ++bin)
      canvas.rectangle(std::rint(column(bin_middle_m(bin) - half_m)),
                       row(bars[static_cast<std::size_t>(bin)]),
                       std::rint(column(bin_middle_m(bin) + half_m)), kTop_px + kHeight_px, particle_colour);
    for (std::size_t k = 1; k < curve.size(); ++k)
      canvas.line(column(bin_middle_m(static_cast<int>(k) - 1)), row(curve[k - 1]),
                  column(bin_middle_m(static_cast<int>(k))), row(curve[k]), 3, estimate_colour);
  }
  draw_key(canvas);
  replace_file(path, encode_png_rgb(canvas.width(), canvas.height(), canvas.pixels()));
}

}  // namespace parloc::tools
