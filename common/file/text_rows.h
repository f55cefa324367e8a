// Files of one row of numbers per line: trajectories, relations.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/text_fields.h"

namespace parloc {

/// read_row(fields) of every line that is neither empty nor a comment ('#'). Throws Error{input} with
/// file:line at the first line for which read_row throws BrokenLine, and for a file that cannot be read to
/// its end.
template <class ReadRow>
auto read_text_rows(LineReader& lines, const ReadRow& read_row) {
  std::vector<decltype(read_row(std::declval<Fields&>()))> rows;
  std::string_view line;
  try {
    while (lines.next(line)) {
      if (lines.cut()) throw BrokenLine{"expected 8 numbers, found a line of more than a mebibyte"};
      Fields fields(line);
      if (fields.empty() || line[line.find_first_not_of(" \t")] == '#') continue;
      rows.push_back(read_row(fields));
    }
  } catch (const BrokenLine& broken) {
    throw input_error(lines.name(), lines.line(), broken.why);
  }
  if (!lines.failure().empty()) throw input_error(lines.name(), lines.line(), lines.failure());
  return rows;
}

}  // namespace parloc
