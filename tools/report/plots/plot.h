// What a plot shows, and its forms: HTML with inline SVG, readable at any width, or pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/plots/axis.h"

namespace parloc::tools {

enum class Marker { none, circle, square, triangle, diamond };

enum class LineKind {
  sampled,  ///< Where samples crowd, their means over a pale line through their extremes.
  exact,    ///< Every step of it, however many there are.
  area,     ///< As exact, and filled from the lower edge on.
};

/// A line of a plot. x and y have the same length. `colour` is a class of report_style(): c1 to c6.
struct PlotSeries {
  std::string label, colour;
  std::vector<double> x, y;
  LineKind kind = LineKind::sampled;
  Marker marker = Marker::none;  ///< At every sample.
  bool dashed = false;           ///< With hollow markers: figures of others, limits.
};

/// An area from -half to +half around zero.
struct PlotBand {
  std::string label, colour;
  std::vector<double> x, half;
};

/// A horizontal line.
struct PlotLevel {
  std::string label, colour;
  double y = 0.0;
  bool labelled_there = false;  ///< Not in the legend.
};

/// Ticks at the lower edge, for moments; in a higher row they do not hide each other.
struct PlotMarks {
  std::string label, colour;
  std::vector<double> x;
  int row = 0;
};

enum class PlotScale {
  linear,       ///< From the smallest to the largest value.
  from_zero,    ///< From 0 to the largest value.
  symmetric,    ///< Zero in the middle. Bands and rare peaks may be cut off; the caption tells.
  logarithmic,  ///< From the smallest positive to the largest value.
  automatic,    ///< Logarithmic if the largest value is far above the median, else from zero.
};

struct Plot {
  std::string title, unit;  ///< Of the values; may be empty.
  PlotScale scale = PlotScale::linear;
  std::vector<PlotSeries> series{};
  std::vector<PlotBand> bands{};
  std::vector<PlotLevel> levels{};
  std::vector<PlotMarks> marks{};
  std::vector<double> span{};  ///< Values that the axis covers too: the same for plots side by side.
  TickText text = TickText::plain;
  bool legend = true;  ///< With one of its own.
};

/// The vertical axis, as the plot's scale asks for; nothing if no series has a value that can be drawn.
std::optional<Axis> value_axis(const Plot& plot);

/// What a reader must know about the vertical axis, to stand behind the unit; mostly empty.
std::string remark(const Plot& plot, const Axis& axis);

/// The horizontal axis of a plot over a size.
Axis size_axis(const Plot& plot, const std::string& name, bool logarithmic = false);

/// Steps up to `until`: which percentage of `all` are values at or below x. Thinned to about a thousand.
PlotSeries cumulative_series(const std::string& label, const std::string& colour, std::vector<double> values,
                             std::size_t all, double until);

/// An upright dashed line from `low` to `high`.
PlotSeries upright(const std::string& label, const std::string& colour, double x, double low, double high);

/// A <figure> with the plot; empty if there is nothing to draw. All text is escaped. Values that are not
/// finite, or not positive on a logarithmic axis, are left out. Needs the style of the page. Lines keep their
/// width and labels their size however wide it is.
std::string render_plot(const Plot& plot, const Axis& x);

/// What the lines are, once for several plots of the same ones.
std::string render_legend(const std::vector<PlotSeries>& series);

/// The bytes of a PNG file: the plots, each `height_px` high, one under the other over the same axis; below
/// them the legend of the first. What has no value to draw is left out.
std::string plot_picture(const std::vector<Plot>& plots, const Axis& x, std::int32_t height_px);

}  // namespace parloc::tools
