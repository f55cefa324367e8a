// How far a long work is, for the person who waits.
#pragma once

#include <chrono>
#include <string_view>

namespace parloc::tools {

/// On stderr: a bar that is redrawn where that is a terminal; else a plain line every 10 % or 10 seconds,
/// whichever comes first. Silent ones print nothing.
class Progress {
 public:
  enum class Style { bar, lines, silent };
  /// `bar` if stderr is a terminal, else `lines`; `silent` on request.
  static Style style_here(bool quiet);

  explicit Progress(Style style);
  ~Progress();  ///< Takes the bar away.
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the work, 0 to 1; `note` says more, for example "120 scans".
  void update(double fraction, std::string_view note = {});

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double fraction, std::string_view note, double elapsed_s) const;

  Style style_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point printed_ = start_;
  int tenths_ = 0;
  bool drawn_ = false;
};

}  // namespace parloc::tools
