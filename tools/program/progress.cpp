#include "tools/program/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <initializer_list>
#include <string>

namespace parloc::tools {
namespace {

std::size_t terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

volatile std::sig_atomic_t g_interrupted = 0;

extern "C" void note_interrupt(int) {
  g_interrupted = 1;
}

}  // namespace

Progress::Progress(bool quiet)
    : style_(quiet                        ? Style::silent
             : isatty(STDERR_FILENO) != 0 ? Style::bar
                                          : Style::lines) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction, std::string_view note) {
  if (style_ == Style::silent) return;
  const Clock::time_point now = Clock::now();
  const auto seconds_since = [&](Clock::time_point t) {
    return std::chrono::duration<double>(now - t).count();
  };
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (style_ == Style::bar) {
    if (drawn_ && seconds_since(printed_) < 0.1) return;
    draw_bar(fraction, note, seconds_since(start_));
    drawn_ = true;
  } else {
    const int tenths = static_cast<int>(fraction * 10.0);
    if (tenths <= tenths_ && seconds_since(printed_) < 10.0) return;
    tenths_ = std::max(tenths, tenths_);
    fmt::print(stderr, "{:3.0f} %  {}  {:.1f} s\n", 100.0 * fraction, note, seconds_since(start_));
  }
  printed_ = now;
}

void Progress::draw_bar(double fraction, std::string_view note, double elapsed_s) const {
  constexpr int width = 30;
  const int filled = static_cast<int>(fraction * width);
  std::string line =
      fmt::format("[{:#<{}}{:.<{}}] {:3.0f} %  ", "", filled, "", width - filled, 100.0 * fraction);
  // A guess from less than 2 % jumps about too much to be worth showing.
  if (fraction > 0.02) line += fmt::format("{:.0f} s left  ", elapsed_s * (1.0 - fraction) / fraction);
  line += note;
  // What is wider than the terminal would go on in a line that is not redrawn.
  fmt::print(stderr, "\r{}\033[K", line.substr(0, terminal_columns() - 1));
  std::fflush(stderr);
}

void catch_interrupts() {
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART | SA_RESETHAND;  // RESETHAND: the second one has its default effect
    sigaction(signal, &action, nullptr);
  }
}

bool interrupted() {
  return g_interrupted != 0;
}

}  // namespace parloc::tools
