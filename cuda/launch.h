// How every kernel is started, and where its memory comes from. A kernel is a plain functor, called once per
// thread: kernel(thread). One whose threads work together says `kPhases` and `Shared`, and is called as
// kernel(thread, phase, shared) once per thread and phase, with a block barrier between the phases. Compiled
// by nvcc it runs on the device; compiled as C++ the same body runs on the host over (block, phase, thread),
// so that tests can hold it against the OpenMP twin without a GPU.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/math/host_device.h"

#if defined(__CUDACC__)
#include <cuda_runtime.h>
#define PARLOC_CUDA_NAMESPACE cuda
#else
#define PARLOC_CUDA_NAMESPACE cuda_on_host
#endif

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
  Kernel::kPhases;
};

inline unsigned blocks_for(std::size_t threads) {
  return static_cast<unsigned>(std::clamp<std::size_t>((threads + kThreads - 1) / kThreads, 1, kMaxBlocks));
}

#if defined(__CUDACC__)
using Stream = cudaStream_t;

inline void check(cudaError_t status, const char* what, const char* file, int line) {
  if (status == cudaSuccess) return;
  (void)cudaGetLastError();  // or the next launch would report this error once more
  throw Error(ErrorKind::internal, std::string(file) + ":" + std::to_string(line) + ": CUDA failed while " +
                                       what + ": " + cudaGetErrorString(status));
}
#define PARLOC_CHECK(call, what) ::parloc::PARLOC_CUDA_NAMESPACE::check((call), (what), __FILE__, __LINE__)

template <class Kernel>
__global__ void __launch_bounds__(kThreads) run_kernel(const Kernel kernel) {
  const Thread me{blockIdx.x, threadIdx.x, gridDim.x};
  if constexpr (Phased<Kernel>) {
    __shared__ typename Kernel::Shared shared;
    for (int phase = 0; phase < Kernel::kPhases; ++phase) {
      if (phase > 0) __syncthreads();
      kernel(me, phase, shared);
    }
  } else {
    kernel(me);
  }
}

template <class Kernel>
void launch(const Kernel& kernel, unsigned blocks, Stream stream) {
  run_kernel<Kernel><<<blocks, kThreads, 0, stream>>>(kernel);
  PARLOC_CHECK(cudaGetLastError(), "launching a kernel");
}

inline void* device_alloc(std::size_t bytes) {
  void* p = nullptr;
  PARLOC_CHECK(cudaMalloc(&p, bytes), "allocating device memory");
  return p;
}
inline void device_free(void* p) {
  (void)cudaFree(p);
}
inline void copy_down(void* to, const void* from, std::size_t bytes, Stream s) {
  PARLOC_CHECK(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, s), "copying to the device");
}
inline void copy_up(void* to, const void* from, std::size_t bytes, Stream s) {
  PARLOC_CHECK(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, s), "copying from the device");
}
inline void synchronise(Stream s) {
  PARLOC_CHECK(cudaStreamSynchronize(s), "waiting for the device");
}
inline Stream make_stream() {
  Stream s = nullptr;
  PARLOC_CHECK(cudaStreamCreateWithFlags(&s, cudaStreamNonBlocking), "creating a stream");
  return s;
}
inline void free_stream(Stream s) {
  (void)cudaStreamDestroy(s);
}
/// Every later call of this host thread is meant for this device.
inline void select_device(int device) {
  PARLOC_CHECK(cudaSetDevice(device), "selecting the device");
}
#else
struct Stream {};

template <class Kernel>
void launch(const Kernel& kernel, unsigned blocks, Stream) {
  for (unsigned block = 0; block < blocks; ++block) {
    if constexpr (Phased<Kernel>) {
      typename Kernel::Shared shared;
      for (int phase = 0; phase < Kernel::kPhases; ++phase)
        for (unsigned thread = 0; thread < kThreads; ++thread)
          kernel(Thread{block, thread, blocks}, phase, shared);
    } else {
      for (unsigned thread = 0; thread < kThreads; ++thread) kernel(Thread{block, thread, blocks});
    }
  }
}

inline void* device_alloc(std::size_t bytes) {
  void* p = std::malloc(bytes > 0 ? bytes : 1);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
inline void device_free(void* p) {
  std::free(p);
}
inline void copy_down(void* to, const void* from, std::size_t bytes, Stream) {
  std::memcpy(to, from, bytes);
}
inline void copy_up(void* to, const void* from, std::size_t bytes, Stream) {
  std::memcpy(to, from, bytes);
}
inline void synchronise(Stream) {}
inline Stream make_stream() {
  return {};
}
inline void free_stream(Stream) {}
inline void select_device(int) {}
#endif

/// Device memory of `size` elements; copies are the named member functions, nothing implicit.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { device_free(data_); }
  /// Grows only: a buffer that is large enough is left alone.
  void reserve(std::size_t size) {
    if (size <= size_) return;
    device_free(data_);
    data_ = nullptr;
    size_ = 0;
    data_ = static_cast<T*>(device_alloc(size * sizeof(T)));
    size_ = size;
  }
  void from_host(const std::vector<T>& host, Stream s) {
    reserve(host.size());
    if (!host.empty()) copy_down(data_, host.data(), host.size() * sizeof(T), s);
  }
  std::vector<T> to_host(std::size_t count, Stream s) const {
    std::vector<T> host(count);
    if (count > 0) copy_up(host.data(), data_, count * sizeof(T), s);
    synchronise(s);
    return host;
  }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
