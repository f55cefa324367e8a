// What the web pages of several commands have in common.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace parloc::tools {

/// For people: name and value.
using Lines = std::vector<std::pair<std::string, std::string>>;

/// From <!DOCTYPE> to the command that made the page. `style` is added to report_style() and bench_style().
std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style = "");

/// A <table> of class `kind` with a row per line; all text is escaped.
std::string facts_table(const Lines& lines, const char* kind = "");

/// Whole multiples of 1, 2 or 5 times a power of ten, from 0 on: about six of them.
std::vector<double> ticks_to(double most);

}  // namespace parloc::tools
