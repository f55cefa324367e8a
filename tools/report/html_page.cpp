#include "tools/report/html_page.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/report/plots/xy_plot.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>{}</title><style>{}{}{}</style></head><body>\n"
      "<h1>{}</h1>\n<p class=\"note\">{}</p><code>{}</code>\n",
      escape_html(title), report_style(), bench_style(), style, escape_html(title), escape_html(date),
      escape_html(command));
}

std::string facts_table(const Lines& lines, const char* kind) {
  std::string html = fmt::format("<table class=\"{}\">", kind);
  for (const auto& [name, value] : lines)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>", escape_html(name), escape_html(value));
  return html + "</table>\n";
}

std::vector<double> ticks_to(double most) {
  const double decade = std::pow(10.0, std::floor(std::log10(most / 4)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade * 7 >= most) step = factor * decade;
  std::vector<double> ticks;
  for (int k = 0; k * step <= most * 1.0001; ++k) ticks.push_back(k * step);
  return ticks;
}

}  // namespace parloc::tools
