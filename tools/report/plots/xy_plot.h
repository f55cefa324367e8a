// A plot of curves over a size, as HTML with inline SVG that reads the same on paper and on a screen.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc::tools {

enum class Marker { circle, square, triangle, diamond };

struct Curve {
  std::string label;
  std::string colour;  ///< A class of report_style(): c1 to c6.
  Marker marker = Marker::circle;
  bool dashed = false;  ///< With hollow markers: figures of others.
  std::vector<double> x, y;
  bool marked = true;  ///< With a marker at every point.
};

/// Steps up to `until`, unmarked: which percentage of `all` are values at or below x. Thinned to about a
/// thousand.
Curve cumulative_curve(const std::string& label, const std::string& colour, std::vector<double> values,
                       std::size_t all, double until);

/// A horizontal line with its name.
struct Level {
  double y;
  std::string label;
};

enum class YUnit { seconds, plain };

struct XyPlot {
  std::string title, x_name;
  bool x_logarithmic = false;
  bool y_logarithmic = true;
  YUnit unit = YUnit::seconds;
  std::vector<double> x_ticks;  ///< Labelled; all of them are drawn.
  std::vector<double> x_span;   ///< The axis covers these values, too.
  std::vector<double> y_span;   ///< The axis covers these values, too: the same for plots side by side.
  std::vector<Curve> curves;
  std::vector<Level> levels;
};

/// A <figure>; empty if there is nothing to draw. Values that are not finite, or not positive on a
/// logarithmic axis, are left out.
std::string render(const XyPlot& plot);

/// What the curves are, once for several plots of the same ones.
std::string render_legend(const std::vector<Curve>& curves);

/// Beside report_style(): what these plots and the tables of numbers need.
const char* bench_style();

}  // namespace parloc::tools
