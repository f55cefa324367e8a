#include "tools/program/log_source.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "common/io/open_log.h"

namespace parloc::tools {

std::vector<LogRecord> read_whole_log(const std::string& path, std::size_t& broken_lines) {
  std::vector<LogRecord> records;
  const auto reader = open_log(path);
  for (LogRecord record; reader->next(record);) records.push_back(std::move(record));
  broken_lines = reader->warnings().broken_lines;
  if (std::none_of(records.begin(), records.end(), is_scan))
    throw input_error(path, 0, "expected at least one scan (FLASER, RLASER or ROBOTLASER1), found none");
  return records;
}

}  // namespace parloc::tools
