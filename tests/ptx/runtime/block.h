// One block of a launch: its threads, their registers, its shared memory, and where its threads meet.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "tests/ptx/device/thread.h"
#include "tests/ptx/runtime/races.h"

namespace ptx {

enum class State { ready, at_barrier, in_warp, finished };

/// The memory of a block. It is used again for other blocks, for it takes longer to make than many blocks to
/// run.
struct BlockMemory {
  struct alignas(16) Line {
    char bytes[16];
  };
  std::vector<Line> shared, registers, local;
  std::vector<Trace> traces;          // of shared memory
  std::vector<std::uint32_t> visits;  // of each thread to each piece
};

struct Block {
  Block(const Launch& launch, std::uint32_t number);
  ~Block();
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  enum class Progress { finished, advanced, looked };
  /// Runs every thread that can run to where it stops next, and lets those go on that have met. `looked`: a
  /// thread read what another block may have to write first.
  Progress run_round(std::mt19937& order);
  /// The kernel and the first thread that is not finished, for a message.
  const Thread& unfinished() const;

  std::uint32_t number;  // of the block, in the order of the grid
  std::uint32_t serial;  // among all blocks that have run: what the detector tells old traces by
  std::vector<Thread> threads;
  std::vector<State> states;
  std::unique_ptr<BlockMemory> memory;

 private:
  struct Ran {
    bool advanced = false, looked = false;
  };
  Ran run_threads(std::mt19937& order);
  bool release_barriers();
  bool meet_at(std::uint32_t barrier);
  [[noreturn]] void explain_standstill() const;
  void count_visits() const;
  std::size_t live() const;

  const Launch& launch_;
  std::size_t
      registers_each_;  // lines of memory from one thread's to the next; 0: one thread at a time has them
};

/// Lets those threads of a warp go on that have met at an instruction of the warp. True if any have.
bool meet_in_warp(Block& block, std::uint32_t warp);
/// Ends the program: says which lanes are missing where this thread of a warp waits.
[[noreturn]] void explain_missing_lanes(const Block& block, const Thread& thread);

}  // namespace ptx
