// A table of texts, for the terminal, for Markdown and for a web page.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc::tools {

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
