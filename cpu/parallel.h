// The one way that the CPU backend loops: contiguous blocks on OpenMP threads, each in a known floating-point
// environment and compiled for the best instruction set.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "cpu/simd.h"

namespace parloc {
class FilterGroup;
}

namespace parloc::cpu {

/// How many threads a stage may use, and scratch memory that keeps its capacity: no allocation once it has
/// grown.
struct Workers {
  int threads = 1;
  std::vector<double> sums;
  std::vector<std::uint64_t> offsets;

  /// `threads` 0: all cores.
  static Workers open(int threads, int device = 0);
  static Workers open(int threads, int device, const std::shared_ptr<FilterGroup>& /*nothing to share*/) {
    return open(threads, device);
  }
  std::string name() const;
  void use() const {}   ///< Of a device only.
  void wait() const {}  ///< Stages are done when they return.

  /// Enough for every stage on so many particles.
  void reserve(std::size_t particles) {
    constexpr std::size_t kMostSums = 12;  // of an estimate, one row per block of 1024 and of 1024 of those
    const std::size_t blocks = particles / 1024 + 1;
    sums.reserve((blocks + blocks / 1024 + 2) * kMostSums);
    offsets.reserve(blocks);
  }
};

/// What the stages are given besides their arguments.
using Queue = Workers;

/// A loaded library may have set flush-to-zero or another rounding mode: strict arithmetic for this scope.
class StrictFloat {
 public:
#if defined(__x86_64__)
  StrictFloat() : saved_(_mm_getcsr()) {
    _mm_setcsr(0x1f80);
  }
  ~StrictFloat() {
    _mm_setcsr(saved_);
  }

 private:
  unsigned saved_;
#elif defined(__aarch64__)
  StrictFloat() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_)::"memory");
    asm volatile("msr fpcr, xzr" ::: "memory");
  }
  ~StrictFloat() {
    asm volatile("msr fpcr, %0" ::"r"(saved_) : "memory");
  }

 private:
  std::uint64_t saved_;
#else
  StrictFloat() {}
#endif
};

/// Particles below which a cheap loop stays on one thread: waking a team costs some microseconds, and
/// milliseconds on a machine that is busy with something else.
constexpr std::size_t kSmallLoop = 8192;

/// A block of a loop. Not inlined: the loop is compiled once per instruction set, not once more for one
/// thread.
template <class Loop>
[[gnu::noinline]] void run_block(const Loop& loop, std::size_t begin, std::size_t end) {
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP { loop(begin, end); });
}

/// loop(begin, end) over [0, count) in at most `threads` contiguous blocks, whose edges are multiples of
/// `grain`. `loop` is a lambda marked PARLOC_SIMD_LOOP that must not throw.
template <class Loop>
void parallel_blocks(std::size_t count, int threads, std::size_t grain, const Loop& loop) {
  const std::size_t grains = (count + grain - 1) / grain;
  const std::size_t wanted =
      static_cast<std::size_t>(threads) < grains ? static_cast<std::size_t>(threads) : grains;
  if (wanted <= 1) {
    if (count > 0) run_block(loop, 0, count);
    return;
  }
  const int team_size = static_cast<int>(wanted);
#pragma omp parallel num_threads(team_size)
  {
    const std::size_t team = static_cast<std::size_t>(omp_get_num_threads());
    const std::size_t me = static_cast<std::size_t>(omp_get_thread_num());
    const std::size_t begin = grains * me / team * grain;
    const std::size_t limit = grains * (me + 1) / team * grain;
    const std::size_t end = limit < count ? limit : count;
    if (begin < end) run_block(loop, begin, end);
  }
}

template <class Loop>
void parallel_for(std::size_t count, int threads, const Loop& loop) {
  parallel_blocks(count, count < kSmallLoop ? 1 : threads, 64, loop);
}

/// task(k) for each k in [0, count), which may take unlike times: a thread that is done takes the next.
/// `task` is a lambda marked PARLOC_SIMD_LOOP that must not throw.
template <class Task>
void parallel_tasks(std::size_t count, int threads, const Task& task) {
  const int team = static_cast<int>(std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(threads)));
#pragma omp parallel for schedule(dynamic, 1) num_threads(team) if (team > 1)
  for (std::size_t k = 0; k < count; ++k) {
    const StrictFloat strict;
    run_simd([&]() PARLOC_SIMD_LOOP { task(k); });
  }
}

}  // namespace parloc::cpu
