#include "tools/report/text/facts.h"

#include <fmt/format.h>

#include "tools/report/text/html_text.h"

namespace parloc::tools {

std::string aligned_text(const Facts& facts, std::size_t width) {
  std::string text;
  for (const Fact& fact : facts) text += fmt::format("{:<{}}{}\n", fact.key, width, fact.value);
  return text;
}

std::string markdown_list(const Facts& facts) {
  std::string text;
  for (const Fact& fact : facts) text += fmt::format("- {}: {}\n", fact.key, fact.value);
  return text;
}

std::string facts_table(const Facts& facts, const char* kind) {
  std::string html = fmt::format("<table class=\"{}\">", kind);
  for (const Fact& fact : facts)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escape_html(fact.key), escape_html(fact.value));
  return html + "</table>\n";
}

}  // namespace parloc::tools
