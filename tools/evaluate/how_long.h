// How long more trials take, by what those so far took.
#pragma once

#include <cstddef>
#include <string>

#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {

/// `trials` of `trial_s` each on so many cores, each with a trial at a time [s].
double work_s(std::size_t trials, double trial_s, std::size_t cores);

/// "35 ms", "12 s", "3.5 min", "7.2 h", "12 days": two digits. A dash for what is not finite.
std::string duration_text(double seconds);

/// A line: `trials` more on the cores here and on more.
std::string how_long_text(std::size_t trials, double trial_s, std::size_t cores_here);
/// Of `trials` and of powers of ten, on 1 to 1000 cores.
Table how_long_table(std::size_t trials, double trial_s);

}  // namespace parloc::tools::evaluate
