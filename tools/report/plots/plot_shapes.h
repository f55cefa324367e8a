// A plot as lines and areas, before it is known whether they become SVG or pixels.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/report/pictures/pixel.h"
#include "tools/report/plots/plot.h"

namespace parloc::tools {

/// The samples in one column of a plot.
struct EnvelopeColumn {
  double x = 0.0;  ///< Of the column's first sample, 0 to 1.
  double first = 0.0, low = 0.0, high = 0.0, last = 0.0, mean = 0.0;
  std::size_t samples = 0;
  bool gap_before = false;  ///< A value that cannot be drawn lies between this column and the one before.
};

/// A series in at most `columns` columns with the minimum and maximum of each, so that no peak is lost.
/// Samples are ordered by x first (stamps may run backwards). x and y have the same length.
std::vector<EnvelopeColumn> envelope(const Axis& axis, const std::vector<double>& x,
                                     const std::vector<double>& y, int columns);

/// What a style sheet or a pen must know of lines.
enum class ShapeKind {
  grid,
  band,  ///< Filled, as pale as can be seen through.
  area,  ///< Filled.
  pale,  ///< A line that another one is drawn over.
  line,
  dashed,
  level,  ///< Dashed, from side to side.
  tick,
};

/// Lines, or the outlines of areas, in fractions of the plot's width and height from its upper left corner.
struct PlotShape {
  ShapeKind kind;
  std::string colour;
  std::vector<std::vector<Pixel>> pieces;
};

/// In the order in which they are drawn.
std::vector<PlotShape> shapes_of(const Plot& plot, const Axis& x, const Axis& y);

}  // namespace parloc::tools
