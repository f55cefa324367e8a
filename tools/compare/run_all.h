// All filters on all logs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "tools/compare/drives.h"
#include "tools/compare/entry.h"
#include "tools/compare/follow.h"

namespace parloc::tools::compare {

struct Request {
  std::vector<Entry> entries;
  StartPlan start;
  std::uint64_t first_seed = 1;
  std::size_t seeds = 1;
  int jobs = 1;  ///< Seeds at once: with more than one, times are those of filters that disturb each other.
  std::function<bool()> stop;  ///< Asked often; may be empty.
  /// Told now and then, on the caller's thread; may be empty.
  std::function<void(double fraction, std::size_t finished)> progress;
};

/// Runs that a log gave, by entry, then in the order of seeds. What `stop` cut off is not there.
using Runs = std::vector<std::vector<FilterRun>>;

struct Outcome {
  Runs runs;
  std::vector<std::string> backends;   ///< As each entry's filter calls its own; "" if it never ran.
  std::size_t finished = 0;            ///< Runs, of entries times seeds.
  std::size_t hits = 0, unmapped = 0;  ///< Of simulated beams, summed over the seeds.
};

/// The first error of any run ends the work and is thrown.
Outcome run_all(const Request& request, const DriveSource& source, const GridMap& map);

}  // namespace parloc::tools::compare
