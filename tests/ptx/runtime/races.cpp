#include "tests/ptx/runtime/races.h"

#include <algorithm>
#include <utility>

#include "tests/ptx/runtime/block.h"
#include "tests/ptx/runtime/device_memory.h"
#include "tests/ptx/runtime/report.h"

namespace ptx {
namespace {

// Keys of places in shared memory: the block, and a bit that no place of global memory has.
constexpr std::uint64_t kSharedKey = 1ull << 63;

Stamp stamp_of(const Thread& thread) {
  return {thread.block->number, static_cast<std::uint16_t>(thread.index),
          static_cast<std::uint16_t>(thread.line), thread.clock};
}

/// Whether what the stamp says happened before what the thread does now.
bool comes_before(const Stamp& stamp, const Thread& thread) {
  if (!stamp) return true;
  if (stamp.block == thread.block->number) {
    if (stamp.thread == thread.index || stamp.clock < thread.block_seen) return true;
    if (stamp.thread / 32u == thread.warp() && stamp.clock < thread.warp_seen[stamp.thread % 32u])
      return true;
  }
  if (thread.known == nullptr) return false;
  const auto block = thread.known->blocks.find(stamp.block);
  if (block == thread.known->blocks.end()) return false;
  if (stamp.clock < block->second.everyone) return true;
  const auto known = block->second.threads.find(stamp.thread);
  return known != block->second.threads.end() && stamp.clock < known->second;
}

bool is_write(Access access) {
  return access == Access::write || access == Access::strong_write || access == Access::update;
}

}  // namespace

Known join(const Known& a, const Known& b) {
  if (a == nullptr || a == b) return b;
  if (b == nullptr) return a;
  auto both = std::make_shared<Knowledge>(*a);
  for (const auto& [number, block] : b->blocks) {
    auto& mine = both->blocks[number];
    mine.everyone = std::max(mine.everyone, block.everyone);
    for (const auto& [thread, clock] : block.threads)
      mine.threads[thread] = std::max(mine.threads[thread], clock);
  }
  return both;
}

RaceDetector& RaceDetector::instance() {
  static RaceDetector detector;
  return detector;
}

RaceDetector::RaceDetector()
    : traces_(static_cast<Trace*>(reserve_pages(DeviceMemory::kSpace / 4 * sizeof(Trace), true))) {}

void RaceDetector::begin() {
  bytes_.clear();
  published_.clear();
}

void RaceDetector::note_global(Thread& thread, std::uint64_t place, unsigned bytes, Access access) {
  for (unsigned done = 0; done < bytes; done += 4)
    note(thread, traces_[(place + done) / 4], thread.launch->number, place + done, std::min(bytes - done, 4u),
         access);
  if (thread.launch->kernel->has_fence) synchronise(thread, place, access);
}

void RaceDetector::note_shared(Thread& thread, std::vector<Trace>& traces, std::uint32_t offset,
                               unsigned bytes, Access access) {
  const std::uint64_t key = kSharedKey | std::uint64_t{thread.block->number} << 24 | offset;
  for (unsigned done = 0; done < bytes; done += 4)
    note(thread, traces[(offset + done) / 4], thread.block->serial, key + done, std::min(bytes - done, 4u),
         access);
  if (thread.launch->kernel->has_fence) synchronise(thread, key, access);
}

/// Whole words and parts of words see each other: a part has a trace of its own besides the word's.
void RaceDetector::note(Thread& thread, Trace& word, std::uint32_t era, std::uint64_t key, unsigned bytes,
                        Access access) {
  const bool shared = (key & kSharedKey) != 0;
  if (word.era != era) {
    word = Trace{};
    word.era = era;
  }
  if (bytes == 4) {
    check(thread, word, shared, access);
    if (!word.by_byte) return;
    for (unsigned byte = 0; byte < 4; ++byte) {
      const auto part = bytes_.find(key + byte);
      if (part != bytes_.end()) check(thread, part->second, shared, access);
    }
    return;
  }
  word.by_byte = true;
  for (unsigned byte = 0; byte < bytes; ++byte) {
    const auto [part, is_new] = bytes_.try_emplace(key + byte, word);
    check(thread, part->second, shared, access);
  }
}

/// Tells of what is not ordered, and keeps who was here.
void RaceDetector::check(Thread& thread, Trace& trace, bool shared, Access access) {
  const bool strong = access != Access::read && access != Access::write;
  const auto against = [&](const Stamp& before, const char* what) {
    if (comes_before(before, thread)) return;
    const bool one_block = before.block == thread.block->number;
    note_race(thread, std::string(is_write(access) ? "writes" : "reads") + (strong ? " atomically" : "") +
                          (shared ? " shared" : " global") + " memory that " +
                          (one_block ? "another thread of the block" : "another block") + " " + what +
                          " at line " + std::to_string(before.line) + ", with nothing between them");
  };
  const Stamp now = stamp_of(thread);
  against(trace.write, "writes");
  if (!strong) against(trace.strong_write, "writes atomically");
  if (is_write(access))
    for (const Stamp& read : trace.reads) against(read, "reads");
  if (access == Access::write) against(trace.strong_read, "reads atomically");

  if (access == Access::write) {
    trace.write = now;
  } else if (access == Access::strong_read) {
    trace.strong_read = now;
  } else if (strong) {
    trace.strong_write = now;
  } else {
    if (trace.reads[0].block != now.block)
      trace.reads[2] = trace.reads[0], trace.reads[1] = Stamp{};
    else if (!trace.reads[0].same_thread(now))
      trace.reads[1] = trace.reads[0];
    trace.reads[0] = now;
  }
}

/// An atomic write publishes what the thread's last fence let it; an atomic read learns it.
void RaceDetector::synchronise(Thread& thread, std::uint64_t key, Access access) {
  if (access == Access::read || access == Access::write) return;
  if (access == Access::strong_write) {
    published_[key] = thread.released;
    return;
  }
  Known& published = published_[key];
  const Known learnt = published;
  if (access == Access::update) published = join(published, thread.released);
  thread.known = join(thread.known, learnt);
}

void note_fence(Thread& thread) {
  Knowledge own;
  auto& block = own.blocks[thread.block->number];
  ++thread.clock;  // what was before is told apart from what comes
  block.everyone = thread.block_seen;
  block.threads[thread.index] = thread.clock;
  thread.released = join(join(thread.released, thread.known), std::make_shared<Knowledge>(std::move(own)));
}

}  // namespace ptx
