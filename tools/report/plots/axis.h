// The axes of a plot: where a value lies along them, and which values are labelled.
#pragma once

#include <string>
#include <vector>

namespace parloc::tools {

/// How the labels of an axis are written.
enum class TickText {
  plain,    ///< "0.5", "2000", "10 k".
  seconds,  ///< "40 ms", of values in seconds.
};

/// The values from one end to the other. Labels count from `zero` in steps of `unit`, both in values.
struct Axis {
  double low = 0.0, high = 1.0;  ///< Ends; of log10 of the value if logarithmic.
  bool logarithmic = false;
  double cut_off = 0.0;  ///< The largest value, if it lies outside; else 0.
  double zero = 0.0, unit = 1.0;
  std::string name{};  ///< Stands at its end: "s", "particles".
  TickText text = TickText::plain;
  std::vector<double> labelled{};  ///< The values with a label; empty: they are chosen.

  bool takes(double value) const;
  /// 0 at the low end, 1 at the high one; values outside lie beyond, by 2 lengths at most.
  double fraction(double value) const;
};

/// A labelled line of the grid.
struct Tick {
  double at;  ///< 0 at the low end, 1 at the high one.
  std::string label;
};

std::vector<Tick> ticks(const Axis& axis);

/// From the first to the last drawable stamp; seconds, minutes or hours, by the span.
Axis time_axis(const std::vector<double>& stamps_s);

/// Covers the values, and zero unless it is logarithmic; with a margin, so that marks at its ends are whole.
Axis size_axis(const std::vector<double>& values, const std::string& name, bool logarithmic, bool margin);

}  // namespace parloc::tools
