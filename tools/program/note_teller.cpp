#include "tools/program/note_teller.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include "common/io/log_notes.h"

namespace parloc::tools {

NoteTeller::NoteTeller(std::string log_name, const std::vector<LidarConfig>& lidars, bool quiet)
    : log_name_(std::move(log_name)), lidars_(lidars), quiet_(quiet) {}

void NoteTeller::tell(const LogWarnings& warnings) {
  if (warnings.notes.size() == seen_) return;
  const std::vector<LogNote> fresh(warnings.notes.begin() + static_cast<std::ptrdiff_t>(seen_),
                                   warnings.notes.end());
  seen_ = warnings.notes.size();
  if (quiet_) return;
  for (const std::string& text : open_notes(fresh, lidars_)) {
    if (isatty(STDERR_FILENO) != 0) std::fputs("\r\033[K", stderr);  // over the progress, which comes again
    fmt::print(stderr, "parloc: {}: {}\n", log_name_, text);
  }
}

}  // namespace parloc::tools
