// The axes of a plot over time, whether it is drawn as SVG or as pixels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/report/plots/svg_plot.h"

namespace parloc::tools {

/// The vertical axis.
struct ValueAxis {
  double low = 0.0, high = 1.0;  ///< Of log10 of the value if logarithmic.
  bool logarithmic = false;
  double cut_off = 0.0;  ///< The largest value, if it lies outside.

  /// 0 at the lower edge, 1 at the upper; values outside lie beyond, by 2 heights at most.
  double fraction(double value) const;
};

/// As the plot's scale asks for; nothing if no series has a value that can be drawn.
std::optional<ValueAxis> value_axis(const Plot& plot);

/// A labelled line of the grid. On a time axis the value is in its unit, from its start.
struct AxisTick {
  double value;
  std::string label;
};
std::vector<AxisTick> ticks(const ValueAxis& axis);
std::vector<AxisTick> ticks(const TimeAxis& axis);

/// What a reader must know about the vertical axis, to stand behind the unit; mostly empty.
std::string remark(const ValueAxis& axis);

/// Whether columns stand for so many samples that a line through all of them would be a solid area.
bool crowded(const std::vector<EnvelopeColumn>& columns);

}  // namespace parloc::tools
