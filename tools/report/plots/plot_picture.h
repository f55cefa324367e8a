// Plots as pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/report/plots/plot.h"

namespace parloc::tools {

/// The bytes of a PNG file: the plots, each `height_px` high, one under the other over the same axis; below
/// them the legend of the first. What has no value to draw is left out.
std::string plot_picture(const std::vector<Plot>& plots, const Axis& x, std::int32_t height_px);

}  // namespace parloc::tools
