#include "tools/report/plots/plot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/math/quantile.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

std::vector<double> drawable_values(const Plot& plot) {
  const auto shown = [&](double y) {
    return drawable(y) && (plot.scale != PlotScale::logarithmic || y > 0.0);
  };
  std::vector<double> values;
  for (const PlotSeries& s : plot.series)
    std::copy_if(s.y.begin(), s.y.end(), std::back_inserter(values), shown);
  return values;
}

double largest_band(const std::vector<PlotBand>& bands) {
  double largest = 0.0;
  for (const PlotBand& band : bands) {
    for (const double half : band.half) {
      if (drawable(half)) largest = std::max(largest, std::abs(half));
    }
  }
  return largest;
}

/// Errors of metres before the filter has settled would flatten the centimetres after it: they are cut off,
/// and the caption says how far they reach.
Axis symmetric_axis(const std::vector<double>& values, double largest, double band) {
  std::vector<double> sizes = values;
  for (double& size : sizes) size = std::abs(size);
  const double usual = nearest_rank(ascending(std::move(sizes)), 98);
  const double shown = usual > 0.0 && largest > 8 * usual ? 2 * usual : largest;
  double limit = std::max(1.1 * shown, std::min(1.1 * band, 2.5 * shown));
  if (shown == 0.0) limit = band;
  if (limit <= 0.0) limit = 1.0;
  return {-limit, limit, false, largest > limit ? largest : 0.0};
}

/// Whether a few values are so far above the rest that a linear axis would flatten it.
bool wants_logarithm(double middle, double high) {
  return middle > 0.0 && high > 15.0 * middle;
}

/// Without the values that are too small to matter beside the largest and the usual one.
Axis upper_log_axis(const std::vector<double>& values, double middle, double high) {
  double least = middle;  // however far above it the largest is: one long pause must not hide the rest
  for (const double v : values) {
    if (v > 1e-4 * high) least = std::min(least, v);
  }
  const double top = std::log10(high) + 0.05;
  return {std::min(std::floor(std::log10(least) * 4) / 4, top - 1.0), top, true};
}

Axis value_axis(const Plot& plot, std::vector<double> values) {
  values.insert(values.end(), plot.span.begin(), plot.span.end());
  for (const PlotLevel& level : plot.levels) {
    if (drawable(level.y)) values.push_back(level.y);
  }
  if (plot.scale == PlotScale::logarithmic) return size_axis(values, "", true, true);
  const auto [low_at, high_at] = std::minmax_element(values.begin(), values.end());
  double low = *low_at, high = *high_at;
  if (plot.scale == PlotScale::symmetric)
    return symmetric_axis(values, std::max(std::abs(low), std::abs(high)), largest_band(plot.bands));
  const double middle = upper_median(ascending(values));
  if (plot.scale == PlotScale::automatic && wants_logarithm(middle, high))
    return upper_log_axis(values, middle, high);
  if (plot.scale != PlotScale::linear) low = std::min(0.0, low);
  if (!(high > low)) low -= 0.5 * std::max(1.0, std::abs(low)), high = low + std::max(1.0, std::abs(high));
  return {low, high + 0.06 * (high - low)};
}

}  // namespace

std::optional<Axis> value_axis(const Plot& plot) {
  const std::vector<double> values = drawable_values(plot);
  if (values.empty()) return std::nullopt;
  Axis axis = value_axis(plot, values);
  axis.text = plot.text;
  return axis;
}

std::string remark(const Plot& plot, const Axis& axis) {
  if (axis.logarithmic && plot.scale != PlotScale::logarithmic) return ", logarithmic";
  return axis.cut_off > 0.0 ? ", peaks up to " + number_text(axis.cut_off, 2) : "";
}

Axis size_axis(const Plot& plot, const std::string& name, bool logarithmic) {
  std::vector<double> values;
  bool marked = false;
  for (const PlotSeries& s : plot.series) {
    values.insert(values.end(), s.x.begin(), s.x.end());
    marked = marked || s.marker != Marker::none;
  }
  return size_axis(values, name, logarithmic, marked);
}

PlotSeries cumulative_series(const std::string& label, const std::string& colour, std::vector<double> values,
                             std::size_t all, double until) {
  constexpr std::size_t kMostPoints = 1000;
  std::sort(values.begin(), values.end());
  const auto percent = [&](std::size_t n) {
    return 100.0 * static_cast<double>(n) / static_cast<double>(all);
  };
  PlotSeries series{label, colour, {0.0}, {0.0}, LineKind::exact};
  const std::size_t stride = values.size() / kMostPoints + 1;
  for (std::size_t k = stride - 1; k < values.size(); k += stride) {
    series.x.insert(series.x.end(), {values[k], values[k]});
    series.y.insert(series.y.end(), {series.y.back(), percent(k + 1)});
  }
  series.x.push_back(until);
  series.y.push_back(percent(values.size()));
  return series;
}

PlotSeries upright(const std::string& label, const std::string& colour, double x, double low, double high) {
  return {label, colour, {x, x}, {low, high}, LineKind::exact, Marker::none, true};
}

}  // namespace parloc::tools
