#include "tests/ptx/runtime/report.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include "tests/ptx/runtime/names.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

/// Whether the file of known races has a line "kernel memory" that this race begins with and speaks of.
bool is_known(const std::string& race) {
  std::ifstream file(settings().known_races);
  for (std::string line; std::getline(file, line);) {
    const std::size_t space = line.find(' ');
    if (line.empty() || line[0] == '#' || space == std::string::npos) continue;
    if (race.rfind(line.substr(0, space), 0) == 0 &&
        race.find(line.substr(space) + " memory") != std::string::npos)
      return true;
  }
  return false;
}

class Report {
 public:
  std::map<std::string, std::uint64_t> races;
  std::map<const Kernel*, KernelCounts> kernels;
  HostCounts host;

  /// Races make the program fail, whatever it was about to say of itself.
  ~Report() {
    bool fails = false;
    for (const auto& [what, times] : races) {
      const bool known = is_known(what);
      fails |= !known;
      std::fprintf(stderr, "ptx: %srace: %s (%llu times)\n", known ? "known " : "", what.c_str(),
                   static_cast<unsigned long long>(times));
    }
    if (settings().report) tell_counts();
    if (!fails) return;
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

const std::map<const Kernel*, KernelCounts>& counts_of_all() {
  return report().kernels;
}

void forget_counts() {
  report().kernels.clear();
  report().host = {};
}

HostCounts& host_counts() {
  return report().host;
}

}  // namespace ptx
