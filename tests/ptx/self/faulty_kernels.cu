#include "tests/ptx/self/kernels.h"

namespace ptx_test {
namespace {

constexpr unsigned kAll = 0xffffffff;

__constant__ std::uint32_t scales[4] = {3, 5, 7, 11};

__global__ void sum_in_warp(std::uint32_t* data) {
  const std::uint32_t mine = data[threadIdx.x];
  std::uint32_t sum = mine;
  for (int offset = 16; offset > 0; offset /= 2) sum += __shfl_xor_sync(kAll, sum, offset);
  std::uint32_t scan = mine;
  for (int offset = 1; offset < 32; offset *= 2) {
    const std::uint32_t before = __shfl_up_sync(kAll, scan, offset);
    if (threadIdx.x % 32 >= offset) scan += before;
  }
  const std::uint32_t odd = __popc(__ballot_sync(kAll, mine % 2));
  data[threadIdx.x] = sum * scales[threadIdx.x / 32 % 4] + scan + odd + __reduce_max_sync(kAll, mine) +
                      (__any_sync(kAll, mine == 0) ? 1 : 0) + __popc(__match_any_sync(kAll, mine / 2));
}

/// data: [0] the sum, [1] how many blocks are done, [2 + block] what each found.
template <bool kFenced>
__global__ void sum_of_blocks(std::uint32_t* data) {
  __shared__ bool last;
  if (threadIdx.x == 0) {
    data[2 + blockIdx.x] = blockIdx.x + 1;
    if (kFenced) __threadfence();
    last = atomicAdd(&data[1], 1) + 1 == gridDim.x;
  }
  __syncthreads();
  if (!last || threadIdx.x != 0) return;
  std::uint32_t sum = 0;
  for (unsigned block = 0; block < gridDim.x; ++block) sum += data[2 + block];
  data[0] = sum;
}

__global__ void dynamic_shared(std::uint32_t* data) {
  extern __shared__ std::uint32_t room[];
  const unsigned count = blockDim.x * blockDim.y, me = threadIdx.y * blockDim.x + threadIdx.x;
  std::uint32_t* mine = data + (blockIdx.y * gridDim.x + blockIdx.x) * count;
  room[me] = mine[me];
  __syncthreads();
  mine[me] = room[count - 1 - me];
}

__global__ void out_of_bounds(std::uint32_t* data) {
  data[threadIdx.x + 1] = 1;
}

__global__ void misaligned(std::uint32_t* data) {
  *data = *reinterpret_cast<std::uint32_t*>(reinterpret_cast<char*>(data) + 1);
}

__global__ void race_in_block(std::uint32_t* data) {
  __shared__ std::uint32_t room[1024];
  room[threadIdx.x] = data[threadIdx.x];
  data[threadIdx.x] = room[(threadIdx.x + 1) % blockDim.x];
}

__global__ void race_of_blocks(std::uint32_t* data) {
  if (threadIdx.x == 0) *data = blockIdx.x;
}

__global__ void divergent_barrier(std::uint32_t* data) {
  if (threadIdx.x < 16) {
    data[threadIdx.x] = 1;
    asm volatile("bar.sync 0;" ::: "memory");
  } else {
    data[threadIdx.x] = 2;
    asm volatile("bar.sync 0;" ::: "memory");
    data[threadIdx.x] = 3;
  }
}

__global__ void wrong_mask(std::uint32_t* data) {
  if (threadIdx.x < 8) data[threadIdx.x] = __shfl_xor_sync(0xffff, data[threadIdx.x], 1);
  __syncthreads();
}

__global__ void not_in_mask(std::uint32_t* data) {
  data[threadIdx.x] = __shfl_xor_sync(0xff, data[threadIdx.x], 1);
}

__global__ void shared_bounds(std::uint32_t* data) {
  __shared__ std::uint32_t room[4];
  room[data[threadIdx.x]] = 1;
  __syncthreads();
  data[threadIdx.x] = room[0];
}

}  // namespace

void start(Which which, std::uint32_t* data, unsigned blocks, unsigned threads, cudaStream_t s) {
  switch (which) {
    case Which::sum_in_warp:
      return sum_in_warp<<<blocks, threads, 0, s>>>(data);
    case Which::sum_of_blocks:
      return sum_of_blocks<true><<<blocks, threads, 0, s>>>(data);
    case Which::unfenced_sum:
      return sum_of_blocks<false><<<blocks, threads, 0, s>>>(data);
    case Which::dynamic_shared:
      return dynamic_shared<<<dim3(blocks, 2), dim3(threads / 2, 2), threads * sizeof *data, s>>>(data);
    case Which::out_of_bounds:
      return out_of_bounds<<<blocks, threads, 0, s>>>(data);
    case Which::misaligned:
      return misaligned<<<blocks, threads, 0, s>>>(data);
    case Which::race_in_block:
      return race_in_block<<<blocks, threads, 0, s>>>(data);
    case Which::race_of_blocks:
      return race_of_blocks<<<blocks, threads, 0, s>>>(data);
    case Which::divergent_barrier:
      return divergent_barrier<<<blocks, threads, 0, s>>>(data);
    case Which::wrong_mask:
      return wrong_mask<<<blocks, threads, 0, s>>>(data);
    case Which::not_in_mask:
      return not_in_mask<<<blocks, threads, 0, s>>>(data);
    case Which::shared_bounds:
      return shared_bounds<<<blocks, threads, 0, s>>>(data);
  }
}

}  // namespace ptx_test
