// The results in their forms: JSON for programs; sentences, tables, plots and pages for people.
#pragma once

#include <string>

#include "tools/bench/published.h"
#include "tools/bench/results.h"
#include "tools/report/text/table.h"

namespace parloc::tools::bench {

/// One object, fields in a fixed order, times in seconds; docs/bench.md explains them.
std::string json_text(const Results& results);

/// One published table beside what was measured here, in seconds; `*` marks what is within 40 ms.
Table published_table(const Results& results, const Place& place, const PublishedTable& published);

/// A line per machine of the paper and per variant: how many sizes are within 40 ms, and the largest in
/// detail.
Table summary_table(const Results& results, const Place& place);

/// Other programs' times, recorded on another machine, beside those of the same models here.
Table peers_table(const Results& results, const Place& place);

/// Every row of a sweep with median, quartiles, p99, number of steps, rays per second.
Table detail_table(const Results& results, const Place& place, Sweep sweep);

/// Of --scale: time and share of every stage.
Table stage_table(const Results& results, const Place& place, std::size_t variant);
Table beams_table(const Results& results, const Place& place);
Table threads_table(const Results& results, const Place& place);
Table largest_table(const Results& results, const Place& place);

/// As the paper's: time over particles, one plot per number of beams, published curves (dashed) beside
/// measured ones.
std::string published_plots(const Results& results, const Place& place);

/// Time over particles, rays per second over beams, and how much faster more threads are.
std::string scale_plots(const Results& results, const Place& place);

/// Lines of at most 100 characters.
std::string terminal_page(const Results& results);
std::string markdown_page(const Results& results);
/// One file: style and drawings are inside, nothing is fetched.
std::string html_page(const Results& results);

}  // namespace parloc::tools::bench
