// The plots of the web page.
#pragma once

#include <string>

#include "tools/bench/results.h"

namespace parloc::tools::bench {

/// As the paper's: time over particles, one plot per number of beams, published curves (dashed) beside
/// measured ones.
std::string published_plots(const Results& results, const Place& place);

/// Time over particles, rays per second over beams, and how much faster more threads are.
std::string scale_plots(const Results& results, const Place& place);

}  // namespace parloc::tools::bench
