// A long work tells the person who waits how far it is, and can be ended by Ctrl-C.
#pragma once

#include <chrono>
#include <string_view>

namespace parloc::tools {

/// On stderr: a bar that is redrawn where that is a terminal; else a plain line every 10 % or 10 seconds,
/// whichever comes first. A quiet one prints nothing.
class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();  ///< Takes the bar away.
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the work, 0 to 1; `note` says more, for example "120 scans".
  void update(double fraction, std::string_view note = {});

 private:
  enum class Style { bar, lines, silent };
  using Clock = std::chrono::steady_clock;
  void draw_bar(double fraction, std::string_view note, double elapsed_s) const;

  Style style_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point printed_ = start_;
  int tenths_ = 0;
  bool drawn_ = false;
};

/// From here on SIGINT and SIGTERM are noted instead of ending the program; a second one ends it at once.
/// Signals that were ignored when the program started (a background job of a script) stay ignored.
void catch_interrupts();

/// Has one come?
bool interrupted();

}  // namespace parloc::tools
