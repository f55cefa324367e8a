// Reads a log once, from beginning to end, as every command does: what reading alone costs.
//   read_log LOG        prints records, scans and beams
#include <fmt/format.h>

#include <cstdio>

#include "common/error.h"
#include "common/inputs/open_log.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: read_log LOG\n");
    return 2;
  }
  try {
    const auto log = parloc::open_log(argv[1]);
    std::size_t records = 0, scans = 0, beams = 0;
    for (parloc::LogRecord record; log->next(record); ++records) {
      scans += record.kind == parloc::RecordKind::scan ? 1 : 0;
      beams += record.scan.ranges_m.size();
    }
    fmt::print("{} records, {} scans, {} beams\n", records, scans, beams);
  } catch (const parloc::Error& error) {
    fmt::print(stderr, "read_log: {}\n", error.what());
    return 3;
  }
}
