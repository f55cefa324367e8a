// Plots over time as HTML with inline SVG, readable at any width.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc::tools {

/// The common time axis of a report's plots.
struct TimeAxis {
  double start_s = 0.0;
  double span_s = 1.0;     ///< Positive.
  double unit_s = 1.0;     ///< What one unit of the labels is worth.
  std::string unit = "s";  ///< "s", "min" or "h".

  /// 0 at the left edge, 1 at the right edge.
  double fraction(double stamp_s) const { return (stamp_s - start_s) / span_s; }
};

/// An axis that covers all drawable stamps; the unit is chosen by the span.
TimeAxis time_axis(const std::vector<double>& stamps_s);

/// The samples in one column of a plot.
struct EnvelopeColumn {
  double x = 0.0;  ///< Of the column's first sample, 0 to 1.
  double low = 0.0, high = 0.0, mean = 0.0;
  std::size_t samples = 0;
  bool gap_before = false;  ///< A value that cannot be drawn lies between this column and the one before.
};

/// A series in at most `columns` columns with the minimum and maximum of each, so that no peak is lost.
/// Samples are ordered by time first (stamps may run backwards). x and y have the same length.
std::vector<EnvelopeColumn> envelope(const TimeAxis& axis, const std::vector<double>& stamp_s,
                                     const std::vector<double>& y, int columns);

/// A line of a plot. `colour` is a class of report_style(): c1 to c6.
struct PlotSeries {
  std::string label, colour;
  std::vector<double> stamp_s, y;
};

/// An area from -half to +half around zero.
struct PlotBand {
  std::string label, colour;
  std::vector<double> stamp_s, half;
};

/// A horizontal line.
struct PlotLevel {
  std::string label, colour;
  double y = 0.0;
};

/// Ticks at the lower edge, for moments; in a higher row they do not hide each other.
struct PlotMarks {
  std::string label, colour;
  std::vector<double> stamp_s;
  int row = 0;
};

enum class PlotScale {
  linear,     ///< From the smallest to the largest value.
  from_zero,  ///< From 0 to the largest value.
  symmetric,  ///< Zero in the middle. Bands and rare peaks may be cut off; the caption tells.
  automatic,  ///< Logarithmic if the largest value is far above the median, else from zero.
};

struct Plot {
  std::string title, unit;
  PlotScale scale = PlotScale::linear;
  std::vector<PlotSeries> series;
  std::vector<PlotBand> bands;
  std::vector<PlotLevel> levels;
  std::vector<PlotMarks> marks;
};

/// A <figure> with the plot; empty if there is nothing to draw. All text is escaped. Needs the style of the
/// page.
std::string render_plot(const Plot& plot, const TimeAxis& axis);

}  // namespace parloc::tools
