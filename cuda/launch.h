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
#include <type_traits>

#include "common/math/host_device.h"
#include "cuda/sequence.h"

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

/// One filter's kernel among those of many, and how many blocks it has.
template <class Kernel>
struct alignas(Sequence::kAlignment) Member {
  Kernel kernel;
  unsigned blocks;
};

[[noreturn]] inline void refuse_to_note() {
  throw Error(ErrorKind::internal, "a kernel that is no part of a filter's step cannot be one of many");
}

inline unsigned blocks_for(std::size_t threads) {
  return static_cast<unsigned>(std::clamp<std::size_t>((threads + kThreads - 1) / kThreads, 1, kMaxBlocks));
}

#if defined(__CUDACC__)
/// Whether this block is the last to come. What any thread of any block wrote before, all threads of the last
/// one see behind it: a fence of one thread hands on all that the barrier has shown it.
__device__ __forceinline__ bool is_last_to_arrive(std::uint32_t* arrived, unsigned blocks, bool& last) {
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    last = atomicAdd(arrived, 1u) + 1 == blocks;
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
    if (alone && !is_last_to_arrive(kernel.arrived, me.blocks, shared.last)) return false;
  }
  if (phase > 0 && !alone) __syncthreads();
  kernel(me, phase, shared);
  return true;
}

template <class Kernel>
__device__ __forceinline__ void run_thread(const Kernel& kernel, const Thread& me) {
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
__global__ void __launch_bounds__(kThreads) run_kernel(const Kernel kernel) {
  run_thread(kernel, Thread{blockIdx.x, threadIdx.x, gridDim.x});
}

template <class Kernel>
void launch(const Kernel& kernel, unsigned blocks, Stream stream) {
  if (noted_by(stream) != nullptr) refuse_to_note();
  run_kernel<Kernel><<<blocks, kThreads, 0, stream->handle>>>(kernel);
  PARLOC_CHECK(cudaGetLastError(), "launching a kernel");
}

/// A row of the grid is a filter: its kernel's members come to shared memory first, where all threads need
/// them.
template <class Kernel>
__global__ void __launch_bounds__(kThreads) run_many(const Member<Kernel>* members) {
  constexpr unsigned kWords = sizeof(Member<Kernel>) / sizeof(std::uint32_t);
  __shared__ alignas(Member<Kernel>) std::uint32_t mine[kWords];
  const auto* const from = reinterpret_cast<const std::uint32_t*>(members + blockIdx.y);
  for (unsigned i = threadIdx.x; i < kWords; i += kThreads) mine[i] = from[i];
  __syncthreads();
  const auto& member = *reinterpret_cast<const Member<Kernel>*>(mine);
  if (blockIdx.x >= member.blocks) return;
  run_thread(member.kernel, Thread{blockIdx.x, threadIdx.x, member.blocks});
}

template <class Kernel>
void start_many(const void* members, unsigned most_blocks, unsigned count, Stream stream) {
  run_many<Kernel><<<dim3(most_blocks, count), kThreads, 0, stream->handle>>>(
      static_cast<const Member<Kernel>*>(members));
  PARLOC_CHECK(cudaGetLastError(), "launching the kernels of many filters");
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
  if (noted_by(stream) != nullptr) refuse_to_note();
  submit(stream, [=] {
    for (unsigned block = 0; block < blocks; ++block) run_block(kernel, block, blocks);
  });
}

template <class Kernel>
void start_many(const void* members, unsigned, unsigned count, Stream) {
  for (unsigned k = 0; k < count; ++k) {
    const auto& member = static_cast<const Member<Kernel>*>(members)[k];
    for (unsigned block = 0; block < member.blocks; ++block) run_block(member.kernel, block, member.blocks);
  }
}
#endif

template <class Kernel>
inline constexpr KernelKind kind_of{sizeof(Member<Kernel>), start_many<Kernel>};

/// A kernel of a filter's step, which may be one of many that are started together (cuda/step_group.h).
template <class Kernel>
void launch_step(const Kernel& kernel, unsigned blocks, Stream stream) {
  static_assert(std::is_trivially_copyable_v<Kernel>);
  Sequence* const noted = noted_by(stream);
  if (noted == nullptr) return launch(kernel, blocks, stream);
  const Member<Kernel> member{kernel, blocks};
  noted->add_kernel(kind_of<Kernel>, &member, blocks);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
