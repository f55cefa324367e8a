// What is said line by line, and tables of texts, for the terminal, for Markdown and for a web page.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace parloc::tools {

/// Both are plain text: the writers escape them.
struct Fact {
  std::string key, value;
};
using Facts = std::vector<Fact>;

/// Appends what fmt::format() makes of the format and its arguments.
template <class... Arguments>
void add_fact(Facts& facts, const char* key, fmt::format_string<Arguments...> format,
              Arguments&&... arguments) {
  facts.push_back({key, fmt::format(format, std::forward<Arguments>(arguments)...)});
}

/// A titled table of facts: configuration, beams used and rejected, map, digest.
struct FactTable {
  std::string title;
  Facts facts;
};

/// A line for each, the values below each other from column `width` on.
std::string aligned_text(const Facts& facts, std::size_t width);
std::string markdown_list(const Facts& facts);
/// A <table> of class `kind` with a row for each.
std::string facts_table(const Facts& facts, const char* kind = "");

struct Column {
  std::string group;  ///< Head over several columns; neighbours of the same group are never parted.
  std::string name;
  bool left = false;  ///< Aligned to the left; numbers are to the right.
};

struct Table {
  std::string title;
  std::vector<Column> columns;
  std::size_t keys = 1;  ///< The first columns, which say what a row is: repeated where a table is parted.
  std::vector<std::vector<std::string>> rows;  ///< Each as long as `columns`.
};

/// Lines of at most `width` characters (if a single group is not wider): a table that is too wide is parted
/// into several, one below the other. Text is ASCII.
std::string terminal_text(const Table& table, std::size_t width);
std::string markdown_text(const Table& table);
/// A <table> of class "numbers"; all text is escaped.
std::string html_text(const Table& table);

}  // namespace parloc::tools
