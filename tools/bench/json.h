// bench.json: everything that was measured, for programs.
#pragma once

#include <string>

#include "tools/bench/results.h"

namespace parloc::tools::bench {

/// One object, fields in a fixed order, times in seconds; docs/bench.md explains them.
std::string json_text(const Results& results);

}  // namespace parloc::tools::bench
