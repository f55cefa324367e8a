// The race detector: of every four bytes it keeps who wrote and read them last in this launch, and tells of
// two threads that touch the same bytes, one of them writing, when nothing orders them. What orders: a
// barrier of the block, bar.warp.sync, and from block to block a fence before an atomic (or volatile) write
// which the other has seen by an atomic (or volatile) read. Launches of a stream follow each other.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "tests/ptx/device/access.h"

namespace ptx {

/// A thread at one of its times.
struct Stamp {
  std::uint32_t block = 0;
  std::uint16_t thread = 0, line = 0;
  std::uint32_t clock = 0;  // 0: nobody
  explicit operator bool() const { return clock != 0; }
  bool same_thread(const Stamp& o) const { return block == o.block && thread == o.thread; }
};

/// The last accesses to some bytes. Of plain reads three are kept: the last, the last of another thread of
/// that block, and the last of another block.
struct Trace {
  std::uint32_t era = 0;  // the launch, or the block of shared memory: before it is forgotten
  bool by_byte = false;   // parts of the four bytes have traces of their own
  Stamp write, strong_write, strong_read, reads[3];
};

/// Up to which time of which threads of other blocks a thread knows.
struct Knowledge {
  struct OfBlock {
    std::uint32_t everyone = 0;  // before this time of the block
    std::unordered_map<std::uint32_t, std::uint32_t> threads;
  };
  std::unordered_map<std::uint32_t, OfBlock> blocks;
};
using Known = std::shared_ptr<const Knowledge>;
/// What either knows.
Known join(const Known& a, const Known& b);

class RaceDetector {
 public:
  static RaceDetector& instance();
  /// Forgets what the launch before did.
  void begin();
  void note_global(Thread& thread, std::uint64_t place, unsigned bytes, Access access);
  void note_shared(Thread& thread, std::vector<Trace>& traces, std::uint32_t offset, unsigned bytes,
                   Access access);

 private:
  RaceDetector();
  void note(Thread& thread, Trace& word, std::uint32_t era, std::uint64_t key, unsigned bytes, Access access);
  void check(Thread& thread, Trace& trace, bool shared, Access access);
  void synchronise(Thread& thread, std::uint64_t key, Access access);

  Trace* traces_ = nullptr;                             // of global memory
  std::unordered_map<std::uint64_t, Trace> bytes_;      // of parts of four bytes
  std::unordered_map<std::uint64_t, Known> published_;  // with the atomics of a place
};

/// What a fence of this thread lets it publish.
void note_fence(Thread& thread);

}  // namespace ptx
