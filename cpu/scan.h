// Inclusive sums of 64-bit integers on several threads. Integer addition is associative: any split gives the
// same.
#pragma once

#include <cstdint>

#include "cpu/parallel.h"

namespace parloc::cpu {

/// out[i] = value(0) + ... + value(i); returns the total. One pass for the sums of the blocks, one to write.
template <class Value>
std::uint64_t inclusive_scan(std::size_t count, Workers& workers, std::uint64_t* out, const Value& value) {
  constexpr std::size_t kGrain = 4096;
  const std::size_t blocks = (count + kGrain - 1) / kGrain;
  if (workers.threads <= 1 || count < kSmallLoop) {
    const StrictFloat strict;
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) out[i] = (sum += value(i));
    return sum;
  }
  parallel_blocks(blocks, workers.threads, 1, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t stop = (b + 1) * kGrain < count ? (b + 1) * kGrain : count;
      std::uint64_t sum = 0;
      for (std::size_t i = b * kGrain; i < stop; ++i) out[i] = (sum += value(i));
    }
  });
  std::uint64_t before = 0;
  workers.offsets.resize(blocks);
  for (std::size_t b = 0; b < blocks; ++b) {
    workers.offsets[b] = before;
    before += out[((b + 1) * kGrain < count ? (b + 1) * kGrain : count) - 1];
  }
  const std::uint64_t* at = workers.offsets.data();
  parallel_blocks(blocks, workers.threads, 1, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t b = begin; b < end; ++b) {
      const std::size_t stop = (b + 1) * kGrain < count ? (b + 1) * kGrain : count;
      for (std::size_t i = b * kGrain; i < stop; ++i) out[i] += at[b];
    }
  });
  return before;
}

}  // namespace parloc::cpu
