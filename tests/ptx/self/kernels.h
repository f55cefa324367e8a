// Tiny kernels, most with one fault, and how to start them.
#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

namespace ptx_test {

enum class Which {
  sum_in_warp,        // right: shuffles, a vote, a reduction
  sum_of_blocks,      // right: the last block adds what the others wrote before a fence and an atomic
  unfenced_sum,       // the same without the fence
  dynamic_shared,     // right: reverses a block through shared memory of a size chosen at the launch, in two
                      // dimensions
  out_of_bounds,      // writes one past the end
  misaligned,         // reads four bytes at an odd place
  race_in_block,      // each thread reads its neighbour's number without a barrier
  race_of_blocks,     // each block writes the same place
  divergent_barrier,  // one warp is at another barrier than the rest
  wrong_mask,         // a shuffle names lanes that have gone another way
  not_in_mask,        // a shuffle's mask does not name the thread itself
  shared_bounds,      // writes behind the shared memory
};
void start(Which which, std::uint32_t* data, unsigned blocks, unsigned threads, cudaStream_t stream);

}  // namespace ptx_test
