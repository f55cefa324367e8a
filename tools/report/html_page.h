// What the web pages of several commands have in common.
#pragma once

#include <string>

namespace parloc::tools {

/// From <!DOCTYPE> to the command that made the page. `style` is added to report_style().
std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style = "");

}  // namespace parloc::tools
