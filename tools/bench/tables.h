// The results as tables: the same for the terminal, for Markdown and for the web page.
#pragma once

#include <string>

#include "tools/bench/published.h"
#include "tools/bench/results.h"
#include "tools/report/text/table.h"

namespace parloc::tools::bench {

/// One published table beside what was measured here, in seconds; `*` marks what is within 40 ms.
Table published_table(const Results& results, const Place& place, const PublishedTable& published);

/// A line per machine of the paper and per variant: how many sizes are within 40 ms, and the largest in
/// detail.
Table summary_table(const Results& results, const Place& place);

/// Every row of a sweep with median, quartiles, p99, number of steps, rays per second.
Table detail_table(const Results& results, const Place& place, Sweep sweep);

/// Of --scale: time and share of every stage.
Table stage_table(const Results& results, const Place& place, std::size_t variant);
Table beams_table(const Results& results, const Place& place);
Table threads_table(const Results& results, const Place& place);
Table largest_table(const Results& results, const Place& place);

}  // namespace parloc::tools::bench
