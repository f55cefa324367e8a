#include "tests/ptx/runtime/stream.h"

#include <set>
#include <string>
#include <utility>

#include "tests/ptx/runtime/report.h"

namespace ptx {
namespace {

std::set<Stream*>& all_streams() {
  static std::set<Stream*> streams;
  return streams;
}

}  // namespace

Stream::Stream() {
  all_streams().insert(this);
}

Stream::~Stream() {
  run();
  all_streams().erase(this);
}

void Stream::add(Work work) {
  (recording_ ? recorded_ : waiting_).push_back(std::move(work));
}

void Stream::run() {
  const std::vector<Work> work = std::exchange(waiting_, {});
  for (const Work& piece : work) piece();
}

void Stream::begin_recording() {
  if (recording_) fault("a stream is recorded twice at a time");
  recording_ = true;
  recorded_.clear();
}

Graph Stream::end_recording() {
  if (!recording_) fault("the recording of a stream ends that is not recorded");
  recording_ = false;
  return {std::exchange(recorded_, {})};
}

void Stream::run_all() {
  for (Stream* stream : all_streams()) stream->run();
}

void Stream::forbid_while_recording(const char* what) {
  for (const Stream* stream : all_streams())
    if (stream->recording_) fault(std::string(what) + " while a stream is recorded");
}

}  // namespace ptx
