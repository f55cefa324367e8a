// Plots as HTML with inline SVG, readable at any width.
#pragma once

#include <string>
#include <vector>

#include "tools/report/plots/plot.h"

namespace parloc::tools {

/// A <figure> with the plot; empty if there is nothing to draw. All text is escaped. Values that are not
/// finite, or not positive on a logarithmic axis, are left out. Needs the style of the page. Lines keep their
/// width and labels their size however wide it is.
std::string render_plot(const Plot& plot, const Axis& x);

/// What the lines are, once for several plots of the same ones.
std::string render_legend(const std::vector<PlotSeries>& series);

}  // namespace parloc::tools
