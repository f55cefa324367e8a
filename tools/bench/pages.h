// The results for people: on the terminal, in Markdown, and as a web page with plots.
#pragma once

#include <string>

#include "tools/bench/results.h"

namespace parloc::tools::bench {

/// Lines of at most 100 characters.
std::string terminal_page(const Results& results);
std::string markdown_page(const Results& results);
/// One file: style and drawings are inside, nothing is fetched.
std::string html_page(const Results& results);

}  // namespace parloc::tools::bench
