#include "common/live/live_scans.h"

#include "common/error.h"

namespace parloc {

bool LiveScans::next(LogRecord& scan) {
  for (;;) {
    try {
      return stream_->next(scan);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      tell(error.what());
    }
  }
}

void LiveScans::tell(const std::string& line) {
  constexpr std::size_t most = 1000;
  std::string key = line;
  std::erase_if(key, [](char c) { return c >= '0' && c <= '9'; });
  if (known_.size() < most && known_.insert(key).second) told_.push_back(line);
}

std::vector<std::string> LiveScans::troubles() {
  if (std::exchange(looked_at_, log_.troubles()) != log_.troubles()) {
    const LogWarnings& now = log_.warnings();
    for (const LogNote& note : now.notes) tell(note.lidar + ": " + note.text);
    for (const std::string& line : now.messages) tell(line);
    for (const std::string& line : log_.take_news()) tell(line);
  }
  return std::exchange(told_, {});
}

}  // namespace parloc
