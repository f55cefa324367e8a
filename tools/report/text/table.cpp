#include "tools/report/text/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::size_t kGap = 2;

/// A run of columns under one head.
struct Group {
  std::size_t first, count;
  std::size_t end() const { return first + count; }
};

std::vector<Group> groups_of(const std::vector<Column>& columns, std::size_t from) {
  std::vector<Group> groups;
  for (std::size_t c = from; c < columns.size(); ++c) {
    if (!groups.empty() && !columns[c].group.empty() && columns[c].group == columns[c - 1].group) {
      ++groups.back().count;
    } else {
      groups.push_back({c, 1});
    }
  }
  return groups;
}

/// Widths that hold every cell, and every head over its columns.
std::vector<std::size_t> widths_of(const Table& t) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < t.columns.size(); ++c) {
    std::size_t width = t.columns[c].name.size();
    for (const auto& row : t.rows) width = std::max(width, row[c].size());
    widths.push_back(width);
  }
  for (const Group& g : groups_of(t.columns, 0)) {
    std::size_t sum = kGap * (g.count - 1);
    for (std::size_t c = g.first; c < g.end(); ++c) sum += widths[c];
    const std::size_t head = t.columns[g.first].group.size();
    if (head > sum) widths[g.first] += head - sum;
  }
  return widths;
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  return left ? fmt::format("{:<{}}", text, width) : fmt::format("{:>{}}", text, width);
}

void finish_line(std::string& text, std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  text += line + "\n";
}

/// The groups' heads, each over its columns: "---- parloc ----". "" if there is none.
std::string head_line(const Table& t, const std::vector<Group>& groups,
                      const std::vector<std::size_t>& widths) {
  std::string line;
  bool any = false;
  for (const Group& g : groups) {
    std::size_t width = kGap * (g.count - 1);
    for (std::size_t c = g.first; c < g.end(); ++c) width += widths[c];
    const std::string& name = t.columns[g.first].group;
    line += std::string(line.empty() ? 0 : kGap, ' ');
    line += !name.empty() && name.size() + 4 <= width ? fmt::format("{:-^{}}", " " + name + " ", width)
                                                      : padded(name, width, false);
    any = any || !name.empty();
  }
  return any ? line : "";
}

std::string part_text(const Table& t, const std::vector<Group>& groups,
                      const std::vector<std::size_t>& widths) {
  std::string text;
  const std::string heads = head_line(t, groups, widths);
  if (!heads.empty()) finish_line(text, heads);
  const auto line = [&](const auto& cell) {
    std::string whole;
    for (const Group& g : groups) {
      for (std::size_t c = g.first; c < g.end(); ++c)
        whole += std::string(whole.empty() ? 0 : kGap, ' ') + padded(cell(c), widths[c], t.columns[c].left);
    }
    finish_line(text, whole);
  };
  line([&](std::size_t c) { return t.columns[c].name; });
  for (const auto& row : t.rows) line([&](std::size_t c) { return row[c]; });
  return text;
}

}  // namespace

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

std::string terminal_text(const Table& t, std::size_t width) {
  const std::vector<std::size_t> widths = widths_of(t);
  std::vector<Group> keys;
  std::size_t key_width = 0;
  for (std::size_t c = 0; c < t.keys; ++c) {
    keys.push_back({c, 1});
    key_width += widths[c] + (c > 0 ? kGap : 0);
  }
  std::string text = t.title.empty() ? "" : t.title + "\n";
  std::vector<Group> part = keys;
  std::size_t used = key_width;
  for (const Group& g : groups_of(t.columns, t.keys)) {
    std::size_t needed = kGap * g.count;
    for (std::size_t c = g.first; c < g.end(); ++c) needed += widths[c];
    if (used + needed > width && part.size() > keys.size()) {
      text += part_text(t, part, widths) + "\n";
      part = keys;
      used = key_width;
    }
    part.push_back(g);
    used += needed;
  }
  return text + part_text(t, part, widths);
}

std::string markdown_text(const Table& t) {
  std::string text = t.title.empty() ? "" : "**" + t.title + "**\n\n";
  const auto line = [&](const auto& cell) {
    for (std::size_t c = 0; c < t.columns.size(); ++c) text += "| " + cell(c) + " ";
    text += "|\n";
  };
  line([&](std::size_t c) {
    const Column& column = t.columns[c];
    return column.group + (column.group.empty() || column.name.empty() ? "" : ": ") + column.name;
  });
  line([&](std::size_t c) { return std::string(t.columns[c].left ? ":--" : "--:"); });
  for (const auto& row : t.rows) line([&](std::size_t c) { return row[c]; });
  return text;
}

std::string html_text(const Table& t) {
  std::string html = "<div class=\"wide\"><table class=\"numbers\">";
  auto out = std::back_inserter(html);
  if (!t.title.empty()) fmt::format_to(out, "<caption>{}</caption>", escape_html(t.title));
  html += "<thead><tr>";
  for (const Group& g : groups_of(t.columns, 0))
    fmt::format_to(out, "<th class=\"group\" colspan=\"{}\">{}</th>", g.count,
                   escape_html(t.columns[g.first].group));
  html += "</tr><tr>";
  for (const Column& c : t.columns)
    fmt::format_to(out, "<th{}>{}</th>", c.left ? " class=\"left\"" : "", escape_html(c.name));
  html += "</tr></thead><tbody>";
  for (const auto& row : t.rows) {
    html += "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool marked = !row[c].empty() && row[c].back() == '*';
      const char* kind = t.columns[c].left ? " class=\"left\"" : marked ? " class=\"within\"" : "";
      fmt::format_to(out, "<td{}>{}</td>", kind, escape_html(row[c]));
    }
    html += "</tr>";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace parloc::tools
