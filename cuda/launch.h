// How every kernel is started. A kernel is a plain functor, called once per thread: kernel(thread). One whose
// threads work together says `kPhases` (or `phases()`, where their number is a setting) and `Shared`, and is
// called as kernel(thread, phase, shared) once per thread and phase, with a block barrier between the phases.
// One whose blocks work together says `join_phase()`: from that phase on only the block runs that was the
// last to get there, and sees what the others have written. That saves a kernel of one block behind it.
// Compiled by nvcc it runs on the device; compiled as C++ the same body runs on the host over (block, phase,
// thread), so that tests can hold it against the OpenMP twin without a GPU.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/math/host_device.h"
#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

constexpr unsigned kThreads = 256;
constexpr unsigned kMaxBlocks = 65535;

/// Who is asking, inside a kernel.
struct Thread {
  unsigned block, thread, blocks;
  PARLOC_HD std::size_t first() const { return std::size_t{block} * kThreads + thread; }
  PARLOC_HD std::size_t stride() const { return std::size_t{blocks} * kThreads; }
};

/// A kernel in phases, with memory shared by the threads of a block.
template <class Kernel>
concept Phased = requires {
  typename Kernel::Shared;
};
template <class Kernel>
PARLOC_HD int phases_of(const Kernel& kernel) {
  if constexpr (requires { Kernel::kPhases; })
    return Kernel::kPhases;
  else
    return kernel.phases();
}

/// A kernel whose last block goes on alone. It has `arrived`, which counts blocks: zero between kernels, and
/// of a queue on which one kernel runs after the other. Its Shared has `bool last`.
template <class Kernel>
concept Joining = Phased<Kernel> && requires(const Kernel& kernel) {
  kernel.join_phase();
};

inline unsigned blocks_for(std::size_t threads) {
  return static_cast<unsigned>(std::clamp<std::size_t>((threads + kThreads - 1) / kThreads, 1, kMaxBlocks));
}

#if defined(__CUDACC__)
/// Whether this block is the last to come. What any thread of any block wrote before, all threads of the last
/// one see behind it: a fence of one thread hands on all that the barrier has shown it.
__device__ __forceinline__ bool is_last_to_arrive(std::uint32_t* arrived, bool& last) {
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    last = atomicAdd(arrived, 1u) + 1 == gridDim.x;
    if (last) *arrived = 0;
    __threadfence();
  }
  __syncthreads();
  return last;
}

/// The first so many phases are written out, so that no thread has to ask in which it is; all or those in
/// front of the join, where their number is known to the compiler and small.
template <class Kernel>
constexpr int written_out() {
  int phases = 0;
  if constexpr (requires { Kernel::kJoin; })
    phases = Kernel::kJoin;
  else if constexpr (requires { Kernel::kPhases; })
    phases = Kernel::kPhases;
  return phases <= 8 ? phases : 0;
}

/// Returns whether the block goes on.
template <class Kernel>
__device__ __forceinline__ bool run_phase(const Kernel& kernel, const Thread& me, int phase,
                                          typename Kernel::Shared& shared) {
  bool alone = false;
  if constexpr (Joining<Kernel>) {
    alone = phase == kernel.join_phase();
    if (alone && !is_last_to_arrive(kernel.arrived, shared.last)) return false;
  }
  if (phase > 0 && !alone) __syncthreads();
  kernel(me, phase, shared);
  return true;
}

template <class Kernel>
__global__ void __launch_bounds__(kThreads) run_kernel(const Kernel kernel) {
  const Thread me{blockIdx.x, threadIdx.x, gridDim.x};
  if constexpr (Phased<Kernel>) {
    __shared__ typename Kernel::Shared shared;
    constexpr int kWrittenOut = written_out<Kernel>();
#pragma unroll
    for (int phase = 0; phase < kWrittenOut; ++phase)
      if (!run_phase(kernel, me, phase, shared)) return;
    const int phases = phases_of(kernel);
    for (int phase = kWrittenOut; phase < phases; ++phase)
      if (!run_phase(kernel, me, phase, shared)) return;
  } else {
    kernel(me);
  }
}

template <class Kernel>
void launch(const Kernel& kernel, unsigned blocks, Stream stream) {
  run_kernel<Kernel><<<blocks, kThreads, 0, stream>>>(kernel);
  PARLOC_CHECK(cudaGetLastError(), "launching a kernel");
}
#else
template <class Kernel>
void run_block(const Kernel& kernel, unsigned block, unsigned blocks) {
  if constexpr (Phased<Kernel>) {
    typename Kernel::Shared shared;
    for (int phase = 0; phase < phases_of(kernel); ++phase) {
      if constexpr (Joining<Kernel>)
        if (phase == kernel.join_phase()) {
          if (++*kernel.arrived < blocks) return;
          *kernel.arrived = 0;
        }
      for (unsigned thread = 0; thread < kThreads; ++thread)
        kernel(Thread{block, thread, blocks}, phase, shared);
    }
  } else {
    for (unsigned thread = 0; thread < kThreads; ++thread) kernel(Thread{block, thread, blocks});
  }
}

template <class Kernel>
void launch(const Kernel& kernel, unsigned blocks, Stream stream) {
  submit(stream, [=] {
    for (unsigned block = 0; block < blocks; ++block) run_block(kernel, block, blocks);
  });
}
#endif

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
