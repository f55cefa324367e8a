// What is said: faults, which end the program at once; races, which are gathered and told at its end; and
// counts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/ptx/device/thread.h"

namespace ptx {

/// Exit codes: of a fault, and of a program that had races.
inline constexpr int kFaultExit = 70, kRaceExit = 71;

/// Ends the program with one line.
[[noreturn]] void fault(const std::string& what);
/// The same, with the kernel, the line of its PTX, the block and the thread.
[[noreturn]] void fault(const Thread& thread, const std::string& what);
std::string text(const Extent& at);

/// One pair of accesses that nothing orders. Told once for each kernel, pair of lines and kind.
void note_race(const Thread& thread, const std::string& what);

/// What all launches of a kernel did.
struct KernelCounts {
  using ByKind = std::array<std::uint64_t, kKinds>;
  std::uint64_t launches = 0, blocks = 0, threads = 0;
  ByKind instructions{};                 // of all threads
  ByKind issued{};                       // of all warps, whose lanes go through a piece together
  std::vector<std::uint64_t> issued_in;  // of these, in each piece between two branches or labels
  std::uint64_t longest_warp = 0;        // issued by one warp, at most
  std::uint64_t block_chains = 0;        // the sum over blocks of what the longest warp of each issued
};
KernelCounts& counts_of(const Kernel& kernel);
const std::map<const Kernel*, KernelCounts>& counts_of_all();
/// Begins anew.
void forget_counts();
/// What the host asked for.
struct HostCounts {
  std::uint64_t allocations = 0, copies = 0, bytes_copied = 0, waits = 0, graphs = 0, nodes = 0,
                graph_launches = 0;
};
HostCounts& host_counts();

}  // namespace ptx
