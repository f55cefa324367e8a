// Streams, which run late: work waits until somebody waits for it. And recorded work.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace ptx {

using Work = std::function<void()>;

struct Graph {
  std::vector<Work> nodes;
};

class Stream {
 public:
  Stream();
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Done later, or recorded.
  void add(Work work);
  /// Does all that waits.
  void run();
  void begin_recording();
  Graph end_recording();
  bool is_recording() const { return recording_; }

  static void run_all();
  /// Ends the program if a stream is being recorded; `what` is not allowed then.
  static void forbid_while_recording(const char* what);

 private:
  bool recording_ = false;
  std::vector<Work> waiting_, recorded_;
};

}  // namespace ptx
