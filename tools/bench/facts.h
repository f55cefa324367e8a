// The results as sentences: the same for the terminal, for Markdown and for the web page.
#pragma once

#include <string>
#include <vector>

#include "tools/bench/results.h"
#include "tools/report/text/facts.h"

namespace parloc::tools::bench {

/// What a reader must know: machine, build, sensor, what is inside the time, what the numbers are.
Facts facts(const Results& results);
/// What was not measured, and why; whether the run was interrupted.
std::vector<std::string> remarks(const Results& results);
/// "no_hit, cloud tracking (800 x 600 ...)".
std::string heading(const Results& results, const Place& place);

}  // namespace parloc::tools::bench
