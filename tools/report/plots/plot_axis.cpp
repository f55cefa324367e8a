#include "tools/report/plots/plot_axis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

double nice_step(double span, int about) {
  const double raw = span / about;
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= raw) return factor * decade;
  }
  return 10 * decade;
}

std::vector<AxisTick> linear_ticks(double low, double high, int about) {
  std::vector<AxisTick> ticks;
  const double step = nice_step(high - low, about);
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step))), 0, 12);
  const double first = std::ceil(low / step - 1e-9);
  for (int k = 0; k <= 2 * about; ++k) {
    const double value = (first + k) * step;
    if (value > high + 1e-9 * step) break;
    ticks.push_back({value, number_text(value, decimals)});
  }
  return ticks;
}

std::vector<AxisTick> log_ticks(double low, double high) {
  std::vector<AxisTick> ticks;
  const int stride = std::max(1, static_cast<int>((high - low) / 5));
  for (int k = static_cast<int>(std::ceil(low)); k <= high; k += stride) {
    const double value = std::pow(10.0, k);
    ticks.push_back({value, number_text(value, std::max(0, -k))});
  }
  return ticks;
}

std::vector<double> drawable_values(const std::vector<PlotSeries>& series) {
  std::vector<double> values;
  for (const PlotSeries& s : series)
    std::copy_if(s.y.begin(), s.y.end(), std::back_inserter(values), drawable);
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

/// The value that 98% of `values` stay below.
double usual_size(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Errors of metres before the filter has settled would flatten the centimetres after it: they are cut off,
/// and the caption says how far they reach.
ValueAxis symmetric_axis(const std::vector<double>& values, double largest, double band) {
  const double usual = usual_size(values);
  const double shown = usual > 0.0 && largest > 8 * usual ? 2 * usual : largest;
  double limit = std::max(1.1 * shown, std::min(1.1 * band, 2.5 * shown));
  if (shown == 0.0) limit = band;
  if (limit <= 0.0) limit = 1.0;
  return {-limit, limit, false, largest > limit ? largest : 0.0};
}

/// Whether a few values are so far above the rest that a linear axis would flatten it.
bool wants_logarithm(std::vector<double>& values, double high) {
  auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle > 0.0 && high > 15.0 * *middle;
}

ValueAxis log_axis(const std::vector<double>& values, double high) {
  double least = high;
  for (const double v : values) {
    if (v > 1e-4 * high) least = std::min(least, v);
  }
  const double top = std::log10(high) + 0.05;
  return {std::min(std::floor(std::log10(least) * 4) / 4, top - 1.0), top, true, 0.0};
}

ValueAxis value_axis(const Plot& plot, std::vector<double> values) {
  for (const PlotLevel& level : plot.levels) {
    if (drawable(level.y)) values.push_back(level.y);
  }
  const auto [low_at, high_at] = std::minmax_element(values.begin(), values.end());
  double low = *low_at, high = *high_at;
  if (plot.scale == PlotScale::symmetric) {
    return symmetric_axis(values, std::max(std::abs(low), std::abs(high)), largest_band(plot.bands));
  }
  if (plot.scale == PlotScale::automatic && wants_logarithm(values, high)) return log_axis(values, high);
  if (plot.scale != PlotScale::linear) low = std::min(0.0, low);
  if (!(high > low)) low -= 0.5 * std::max(1.0, std::abs(low)), high = low + std::max(1.0, std::abs(high));
  return {low, high + 0.06 * (high - low), false, 0.0};
}

}  // namespace

double ValueAxis::fraction(double value) const {
  const double v = logarithmic ? std::log10(std::max(value, 1e-30)) : value;
  return std::clamp((v - low) / (high - low), -2.0, 3.0);
}

std::optional<ValueAxis> value_axis(const Plot& plot) {
  const std::vector<double> values = drawable_values(plot.series);
  return values.empty() ? std::nullopt : std::optional(value_axis(plot, values));
}

std::vector<AxisTick> ticks(const ValueAxis& axis) {
  if (axis.logarithmic) return log_ticks(axis.low, axis.high);
  const std::vector<AxisTick> few = linear_ticks(axis.low, axis.high, 4);
  return few.size() > 2 ? few : linear_ticks(axis.low, axis.high, 8);  // one label alone gives no scale
}

std::vector<AxisTick> ticks(const TimeAxis& axis) {
  return linear_ticks(0.0, axis.span_s / axis.unit_s, 6);
}

std::string remark(const ValueAxis& axis) {
  if (axis.logarithmic) return ", logarithmic";
  return axis.cut_off > 0.0 ? ", peaks up to " + number_text(axis.cut_off, 2) : "";
}

bool crowded(const std::vector<EnvelopeColumn>& columns) {
  return std::any_of(columns.begin(), columns.end(), [](const EnvelopeColumn& c) { return c.samples > 2; });
}

}  // namespace parloc::tools
