#include "tools/program/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace parloc::tools {
namespace {

volatile std::sig_atomic_t g_interrupted = 0;

extern "C" void note_interrupt(int) {
  g_interrupted = 1;
}

}  // namespace

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
