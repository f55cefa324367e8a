#include "tests/ptx/runtime/report.h"

#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/ptx/runtime/names.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

class Report {
 public:
  std::map<std::string, std::uint64_t> races;
  std::map<const Kernel*, KernelCounts> kernels;
  HostCounts host;

  /// Races make the program fail, whatever it was about to say of itself.
  ~Report() {
    for (const auto& [what, times] : races)
      std::fprintf(stderr, "ptx: race: %s (%llu times)\n", what.c_str(),
                   static_cast<unsigned long long>(times));
    if (settings().report) tell_counts();
    if (races.empty()) return;
    std::fflush(nullptr);
    std::_Exit(kRaceExit);
  }

 private:
  void tell_counts() const {
    for (const auto& [kernel, counts] : kernels) {
      std::fprintf(stderr, "ptx: %s: %llu launches, %llu threads", readable_name(kernel->name).c_str(),
                   static_cast<unsigned long long>(counts.launches),
                   static_cast<unsigned long long>(counts.threads));
      for (std::size_t kind = 0; kind < kKinds; ++kind)
        if (counts.instructions[kind] > 0)
          std::fprintf(stderr, ", %s %llu", kKindNames[kind],
                       static_cast<unsigned long long>(counts.instructions[kind]));
      std::fprintf(stderr, "\n");
    }
    std::fprintf(
        stderr,
        "ptx: host: %llu allocations, %llu copies of %llu bytes, %llu waits, %llu graphs of %llu nodes, "
        "%llu launches of graphs\n",
        static_cast<unsigned long long>(host.allocations), static_cast<unsigned long long>(host.copies),
        static_cast<unsigned long long>(host.bytes_copied), static_cast<unsigned long long>(host.waits),
        static_cast<unsigned long long>(host.graphs), static_cast<unsigned long long>(host.nodes),
        static_cast<unsigned long long>(host.graph_launches));
  }
};

Report& report() {
  static Report all;
  return all;
}

}  // namespace

std::string text(const Extent& at) {
  return "(" + std::to_string(at.x) + "," + std::to_string(at.y) + "," + std::to_string(at.z) + ")";
}

void fault(const std::string& what) {
  std::fprintf(stderr, "ptx: %s\n", what.c_str());
  std::fflush(nullptr);
  std::_Exit(kFaultExit);
}

void fault(const Thread& thread, const std::string& what) {
  const Kernel& kernel = *thread.launch->kernel;
  fault(readable_name(kernel.name) + ", " + kernel.file + " line " + std::to_string(thread.line) +
        ", block " + text(thread.block_id) + ", thread " + text(thread.id) + ": " + what);
}

void note_race(const Thread& thread, const std::string& what) {
  const Kernel& kernel = *thread.launch->kernel;
  ++report().races[readable_name(kernel.name) + ", " + kernel.file + " line " + std::to_string(thread.line) +
                   ": " + what];
}

KernelCounts& counts_of(const Kernel& kernel) {
  return report().kernels[&kernel];
}

HostCounts& host_counts() {
  return report().host;
}

}  // namespace ptx
