// What is no stage of a step and standard work on arrays of the device: by Thrust, on the queue's stream and
// in memory that was reserved for it. Compiled as C++ the standard library does it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "cuda/queue.h"

#if defined(__CUDACC__)
#include <thrust/copy.h>
#include <thrust/count.h>
#include <thrust/execution_policy.h>
#include <thrust/fill.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/system_error.h>
#endif

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Scratch for lists of so many entries: what Thrust asks for, with room to spare.
constexpr std::size_t list_scratch_bytes(std::size_t entries) {
  return (std::size_t{1} << 16) + entries / 16;
}

struct IsZero {
  PARLOC_HD bool operator()(std::uint32_t value) const { return value == 0; }
};

#if defined(__CUDACC__)
/// Hands out reserved memory, piece after piece, for one call of Thrust; nothing is ever allocated here.
class ListScratch {
 public:
  using value_type = char;

  explicit ListScratch(const DeviceBuffer<char>& memory) : memory_(memory) {}
  /// Throws Error{backend} where too little was reserved.
  char* allocate(std::ptrdiff_t bytes) {
    constexpr std::size_t kAligned = 256;
    const std::size_t size = (static_cast<std::size_t>(bytes) + kAligned - 1) / kAligned * kAligned;
    if (used_ + size > memory_.size()) check_memory(cudaErrorMemoryAllocation, size, "scratch");
    char* const at = memory_.data() + used_;
    used_ += size;
    return at;
  }
  void deallocate(char*, std::size_t) {}

 private:
  const DeviceBuffer<char>& memory_;
  std::size_t used_ = 0;
};

/// Runs work(policy); what Thrust has to say becomes an Error.
template <class Work>
auto with_thrust(const Queue& queue, const Work& work) {
  ListScratch scratch(queue.scratch.lists);
  try {
    return work(thrust::cuda::par_nosync(scratch).on(static_cast<Stream>(queue)->handle));
  } catch (const thrust::system_error& error) {
    (void)cudaGetLastError();
    throw Error(ErrorKind::internal, std::string("CUDA failed in Thrust: ") + error.what());
  }
}
#endif

/// Asynchronous.
inline void fill(std::uint32_t* first, std::size_t count, std::uint32_t value, const Queue& queue) {
#if defined(__CUDACC__)
  with_thrust(queue, [&](const auto& policy) { thrust::fill_n(policy, first, count, value); });
#else
  submit(queue, [=] { std::fill_n(first, count, value); });
#endif
}
/// Waits.
inline std::size_t count_zeros(const std::uint32_t* first, std::size_t count, const Queue& queue) {
#if defined(__CUDACC__)
  return static_cast<std::size_t>(with_thrust(
      queue, [&](const auto& policy) { return thrust::count_if(policy, first, first + count, IsZero{}); }));
#else
  queue.wait();
  return static_cast<std::size_t>(std::count_if(first, first + count, IsZero{}));
#endif
}
/// Writes the indices of all zeros, ascending; waits, and returns how many there are. `to`: room for `count`.
inline std::size_t list_zeros(const std::uint32_t* first, std::size_t count, std::uint32_t* to,
                              const Queue& queue) {
#if defined(__CUDACC__)
  return with_thrust(queue, [&](const auto& policy) {
    const thrust::counting_iterator<std::uint32_t> index(0);
    return static_cast<std::size_t>(thrust::copy_if(policy, index, index + count, first, to, IsZero{}) - to);
  });
#else
  queue.wait();
  std::size_t listed = 0;
  for (std::size_t k = 0; k < count; ++k)
    if (first[k] == 0) to[listed++] = static_cast<std::uint32_t>(k);
  return listed;
#endif
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
