#include "tools/report/html_page.h"

#include <fmt/format.h>

#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>{}</title><style>{}{}</style></head><body>\n"
      "<h1>{}</h1>\n<p class=\"note\">{}</p><code>{}</code>\n",
      escape_html(title), report_style(), style, escape_html(title), escape_html(date), escape_html(command));
}

}  // namespace parloc::tools
