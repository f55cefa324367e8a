// A CARMEN log read to its end.
#pragma once

#include <gtest/gtest.h>

#include "common/io/log.h"

namespace parloc::test {

struct Read {
  std::vector<LogRecord> records;
  LogWarnings warnings;
};

inline Read drain(LogReader& reader) {
  Read read;
  LogRecord record;
  while (reader.next(record)) read.records.push_back(record);
  EXPECT_FALSE(reader.next(record)) << "the end stays the end";
  read.warnings = reader.warnings();
  return read;
}

inline Read read_text(const std::string& text) {
  return drain(*carmen_log_from_text(text, "x.log"));
}
inline Read read_file(const std::string& path) {
  return drain(*open_carmen_log(path));
}

}  // namespace parloc::test
