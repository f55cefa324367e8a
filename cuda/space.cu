#include "cuda/space.h"

#if defined(__CUDACC__)
#include <cub/device/device_scan.cuh>
#endif

#include "common/filter/filter_backend.h"
#include "common/math/block_sum.h"

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

}  // namespace

Queue::Queue(int device) : device_(device), device_name_(usable_device(device)) {
  use();  // before anything is allocated
  stream_ = make_stream();
}

void Queue::reserve(std::size_t particles) {
  const std::size_t blocks = sum_blocks(particles);
  scratch.sums.reserve((blocks + sum_blocks(blocks) + 3) * 12);  // the widest sum has 12 terms
  scratch.best.reserve(2);
#if defined(__CUDACC__)
  std::size_t bytes = 0;
  std::uint64_t* none = nullptr;
  PARLOC_CHECK(cub::DeviceScan::InclusiveSum(nullptr, bytes, none, none, static_cast<int>(particles)),
               "sizing the scan");
  scratch.scan.reserve(bytes > 0 ? bytes : 1);
#endif
}

void inclusive_scan(const std::uint64_t* in, std::uint64_t* out, std::size_t count, Queue& queue) {
#if defined(__CUDACC__)
  std::size_t bytes = queue.scratch.scan.size();
  PARLOC_CHECK(cub::DeviceScan::InclusiveSum(queue.scratch.scan.data(), bytes, in, out,
                                             static_cast<int>(count), Stream(queue)),
               "scanning weights");
#else
  submit(queue, [=] {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) out[i] = (sum += in[i]);
  });
#endif
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
