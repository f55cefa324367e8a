// A picture of a work that goes on, for the person who waits.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace parloc::tools {

/// A PNG that is drawn anew now and then, and beside it a page that loads it every second. Both are removed
/// at the end. The next picture comes after two seconds, or after forty times what the last one took: it
/// costs at most a fortieth of the time. A picture that cannot be written ends nothing: the next one is
/// tried.
class LivePicture {
 public:
  /// Throws Error{output} if the page cannot be written. `report`: file name of what the page leads to at the
  /// end.
  LivePicture(const std::string& picture, const std::string& page, const std::string& title,
              const std::string& report);
  ~LivePicture();
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  /// draw(path) writes the PNG; called when it is time.
  void offer(const std::function<void(const std::string& path)>& draw);

 private:
  using Clock = std::chrono::steady_clock;
  std::string picture_, page_;
  Clock::time_point next_ = Clock::now();
};

}  // namespace parloc::tools
