#include "tools/report/plots/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/report/text/html_text.h"
#include "tools/report/text/numbers.h"

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

std::string label_of(double value, TickText text, int decimals) {
  if (text == TickText::seconds && value > 0.0) {
    if (value >= 0.9995) return significant(value, value >= 100 ? 3 : 1) + " s";
    if (value >= 0.9995e-3) return significant(1e3 * value, 1) + " ms";
    return significant(1e6 * value, 1) + " \xC2\xB5s";
  }
  for (const auto& [size, letter] : {std::pair{1e9, " G"}, {1e6, " M"}, {1e4, " k"}}) {
    if (value >= size) return fmt::format("{:g}{}", value / (size == 1e4 ? 1e3 : size), letter);
  }
  return number_text(value, decimals);
}

void add_linear(std::vector<Tick>& result, const Axis& axis, int about) {
  const double low = (axis.low - axis.zero) / axis.unit, high = (axis.high - axis.zero) / axis.unit;
  const double step = nice_step(high - low, about);
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step))), 0, 12);
  const double first = std::ceil(low / step - 1e-9);
  for (int k = 0; k <= 2 * about; ++k) {
    const double value = (first + k) * step;
    if (value > high + 1e-9 * step) break;
    result.push_back({(value - low) / (high - low), label_of(value, axis.text, decimals)});
  }
}

/// Powers of ten; where these are few, 2 and 5 times them as well.
void add_logarithmic(std::vector<Tick>& result, const Axis& axis) {
  const int stride = std::max(1, static_cast<int>((axis.high - axis.low) / 5));
  const bool few = std::floor(axis.high) - std::ceil(axis.low) < 2.0;
  for (int k = static_cast<int>(std::floor(axis.low)); k <= axis.high; k += stride) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, k), at = axis.fraction(value);
      if ((factor > 1.0 && !few) || at < 0.0 || at > 1.0) continue;
      result.push_back({at, label_of(value, axis.text, std::max(0, -k))});
    }
  }
}

}  // namespace

bool Axis::takes(double value) const {
  return drawable(value) && (!logarithmic || value > 0.0);
}

double Axis::fraction(double value) const {
  const double v = logarithmic ? std::log10(std::max(value, 1e-30)) : value;
  return std::clamp((v - low) / (high - low), -2.0, 3.0);
}

std::vector<Tick> ticks(const Axis& axis) {
  std::vector<Tick> result;
  for (const double value : axis.labelled) {
    const double at = axis.fraction(value);
    if (axis.takes(value) && at > -1e-9 && at <= 1.0) result.push_back({at, label_of(value, axis.text, 6)});
  }
  if (!axis.labelled.empty()) return result;
  if (axis.logarithmic) {
    add_logarithmic(result, axis);
    return result;
  }
  constexpr int kAbout = 6;
  add_linear(result, axis, kAbout);
  if (result.size() > 2) return result;
  result.clear();  // one label alone gives no scale
  add_linear(result, axis, 2 * kAbout);
  return result;
}

Axis time_axis(const std::vector<double>& stamps_s) {
  Axis axis;
  bool any = false;
  for (const double stamp : stamps_s) {
    if (!drawable(stamp)) continue;
    axis.low = any ? std::min(axis.low, stamp) : stamp;
    axis.high = any ? std::max(axis.high, stamp) : stamp;
    any = true;
  }
  if (!any) axis.low = axis.high = 0.0;
  if (!(axis.high > axis.low)) axis.high = axis.low + 1.0;
  const double span_s = axis.high - axis.low;
  axis.zero = axis.low;
  axis.unit = span_s <= 600 ? 1 : span_s <= 3 * 3600 ? 60 : 3600;
  axis.name = span_s <= 600 ? "s" : span_s <= 3 * 3600 ? "min" : "h";
  return axis;
}

Axis size_axis(const std::vector<double>& values, const std::string& name, bool logarithmic, bool margin) {
  Axis axis;
  axis.name = name;
  axis.logarithmic = logarithmic;
  double low = logarithmic ? 1e300 : 0.0, high = -1e300;
  for (const double value : values) {
    if (!axis.takes(value)) continue;
    low = std::min(low, logarithmic ? std::log10(value) : value);
    high = std::max(high, logarithmic ? std::log10(value) : value);
  }
  if (high == -1e300) low = high = 0.0;
  const double more = margin ? std::max(0.04 * (high - low), logarithmic ? 0.05 : 0.0) : 0.0;
  axis.low = logarithmic ? low - more : low;
  axis.high = high + more;
  if (!(axis.high > axis.low)) axis.high = axis.low + 1.0;
  return axis;
}

}  // namespace parloc::tools
