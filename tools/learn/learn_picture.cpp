#include "tools/learn/learn.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/file/output_file.h"
#include "tools/report/plots/plot.h"

namespace parloc::tools {
namespace {

constexpr int kBins = 250;
constexpr double kSpan_m = 2.5;  // on either side
constexpr double kLeastDensity = 1e-4, kMostDensity = 30.0;

using Densities = std::array<double, kBins>;

double place_m(double bins) {
  return kSpan_m * (2.0 * bins / kBins - 1.0);
}
double bin_middle_m(int bin) {
  return place_m(bin + 0.5);
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

/// Steps, from the left edge of each bin to its right edge.
PlotSeries histogram(const Densities& densities) {
  PlotSeries series{"measured", "c4", {}, {}, LineKind::area};
  for (int bin = 0; bin < kBins; ++bin) {
    const double density = densities[static_cast<std::size_t>(bin)];
    series.x.insert(series.x.end(), {place_m(bin), place_m(bin + 1)});
    series.y.insert(series.y.end(), {density, density});
  }
  return series;
}

PlotSeries curve(const Densities& densities) {
  PlotSeries series{"fitted mixture", "c1", {}, {}, LineKind::exact};
  for (int bin = 0; bin < kBins; ++bin) {
    series.x.push_back(bin_middle_m(bin));
    series.y.push_back(std::max(densities[static_cast<std::size_t>(bin)], kLeastDensity));
  }
  return series;
}

}  // namespace

void write_mixture_picture(const std::string& path, const RangePairs& ranges, const Mixture& mixture) {
  const std::vector<RangePair> pairs = on_walls(ranges);
  Plot plot{"measured minus expected range [m], density", "1 per m", PlotScale::logarithmic};
  plot.span = {kLeastDensity, kMostDensity};
  if (!pairs.empty())
    plot.series = {histogram(measured(pairs)), curve(fitted(pairs, mixture, ranges.range_max_m))};
  Axis offset = size_axis({-kSpan_m, kSpan_m}, "m", false, false);
  for (int half_m = -5; half_m <= 5; ++half_m) offset.labelled.push_back(0.5 * half_m);
  constexpr std::int32_t kHeight_px = 440;
  replace_file(path, plot_picture({plot}, offset, kHeight_px));
}

}  // namespace parloc::tools
