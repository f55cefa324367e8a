#include "cuda/space.h"

#include "common/filter/filter_backend.h"
#include "cuda/block_sum.h"
#include "cuda/scan.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

#if defined(__CUDACC__)
std::string usable_device(int device) {
  const int devices = cuda_device_count();
  if (devices == 0)
    throw Error(ErrorKind::backend,
                "backend cuda: no CUDA device answers (no GPU, or no driver); use --backend cpu");
  if (device < 0 || device >= devices)
    throw Error(ErrorKind::backend, "backend cuda: there is no device " + std::to_string(device) +
                                        "; parloc devices lists " + std::to_string(devices));
  cudaDeviceProp p{};
  PARLOC_CHECK(cudaGetDeviceProperties(&p, device), "reading the device's properties");
  return p.name;
}
#else
std::string usable_device(int) {
  return "kernels on the host";
}
#endif

struct ReadValue {
  const std::uint64_t* from;
  PARLOC_HD std::uint64_t operator()(std::size_t i) const { return from[i]; }
};

struct AddBefore {
  std::uint64_t* sums;
  const std::uint64_t* before;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < count; i += me.stride()) sums[i] += before[i / kSumBlock];
  }
};

}  // namespace

Queue::Queue(int device) : device_(device), device_name_(usable_device(device)) {
  use();  // before anything is allocated
  stream_ = make_stream();
  scratch.arrived.from_host({0}, stream_);
  scratch.largest.from_host({LargestWeight{}}, stream_);
  scratch.heaviest.reserve(2 * kHeaviestBlocks + 1);
}

void Queue::reserve(std::size_t particles) {
  const std::size_t blocks = sum_blocks(particles);
  const SumShape shape = SumShape::of(blocks);
  const std::size_t sums = (shape.parts > 1 ? shape.parts * blocks : 0) + blocks + sum_blocks(blocks) + 3;
  scratch.sums.reserve(sums * 12);  // the widest sum has 12 terms
  scratch.before.reserve(blocks);
}

void inclusive_scan(std::uint64_t* sums, std::size_t count, Queue& queue) {
  if (count == 0) return;
  queue.scratch.before.reserve(sum_blocks(count));
  std::uint64_t* const before = queue.scratch.before.data();
  scan_in_blocks(ReadValue{sums}, count, sums, before, queue);
  if (count > kSumBlock) launch(AddBefore{sums, before, count}, blocks_for(count), queue);
}

}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
int cuda_device_count() {
  int count = 0;
  if (cudaGetDeviceCount(&count) != cudaSuccess) {
    (void)cudaGetLastError();
    return 0;
  }
  return count;
}

std::vector<std::string> describe_cuda_devices() {
  std::vector<std::string> lines;
  for (int d = 0; d < cuda_device_count(); ++d) {
    cudaDeviceProp p{};
    PARLOC_CHECK(cudaGetDeviceProperties(&p, d), "reading a device's properties");
    lines.push_back("cuda " + std::to_string(d) + ": " + std::string(p.name) + ", compute capability " +
                    std::to_string(p.major) + "." + std::to_string(p.minor) + ", " +
                    std::to_string(p.totalGlobalMem >> 20) + " MiB");
  }
  if (lines.empty()) lines.push_back("cuda: built, but no device answers (no GPU, or no driver)");
  return lines;
}
#endif

}  // namespace parloc
