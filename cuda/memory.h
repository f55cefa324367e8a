// Memory of the device, and memory of the host that the device copies from and to. Compiled as C++ both are
// plain host memory.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "cuda/sequence.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

#if defined(__CUDACC__)
/// Too little memory is not a defect of parloc: it says so in words.
inline void check_memory(cudaError_t status, std::size_t bytes, const char* of) {
  if (status != cudaErrorMemoryAllocation) return PARLOC_CHECK(status, "allocating memory");
  (void)cudaGetLastError();
  throw Error(ErrorKind::backend, "backend cuda: no " + std::to_string((bytes >> 20) + 1) + " MiB of " + of +
                                      " left; use fewer particles, a coarser map or --backend cpu");
}
inline void* device_alloc(std::size_t bytes) {
  void* p = nullptr;
  check_memory(cudaMalloc(&p, bytes), bytes, "device memory");
  return p;
}
inline void device_free(void* p) {
  (void)cudaFree(p);
}
/// Page-locked, so that copies from and to it are asynchronous and can be recorded.
inline void* host_alloc(std::size_t bytes) {
  void* p = nullptr;
  check_memory(cudaMallocHost(&p, bytes), bytes, "page-locked memory");
  return p;
}
inline void host_free(void* p) {
  (void)cudaFreeHost(p);
}
inline void copy_down(void* to, const void* from, std::size_t bytes, Stream s) {
  if (Sequence* const noted = noted_by(s)) return noted->add_copy_down(to, from, bytes);
  PARLOC_CHECK(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, s->handle), "copying to the device");
}
inline void copy_up(void* to, const void* from, std::size_t bytes, Stream s) {
  if (Sequence* const noted = noted_by(s)) return noted->add_copy_up(to, from, bytes);
  PARLOC_CHECK(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, s->handle),
               "copying from the device");
}
inline void copy_across(void* to, const void* from, std::size_t bytes, Stream s) {
  PARLOC_CHECK(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, s->handle),
               "copying on the device");
}
#else
inline void* device_alloc(std::size_t bytes) {
  void* p = std::malloc(bytes > 0 ? bytes : 1);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
inline void device_free(void* p) {
  std::free(p);
}
inline void* host_alloc(std::size_t bytes) {
  return device_alloc(bytes);
}
inline void host_free(void* p) {
  std::free(p);
}
inline void copy_down(void* to, const void* from, std::size_t bytes, Stream s) {
  if (Sequence* const noted = noted_by(s)) return noted->add_copy_down(to, from, bytes);
  submit(s, [=] { std::memcpy(to, from, bytes); });
}
inline void copy_up(void* to, const void* from, std::size_t bytes, Stream s) {
  if (Sequence* const noted = noted_by(s)) return noted->add_copy_up(to, from, bytes);
  submit(s, [=] { std::memcpy(to, from, bytes); });
}
inline void copy_across(void* to, const void* from, std::size_t bytes, Stream s) {
  submit(s, [=] { std::memcpy(to, from, bytes); });
}
#endif

/// Memory of `size` elements, not initialised.
template <class T, void* (*kAlloc)(std::size_t), void (*kFree)(void*)>
class Buffer {
 public:
  Buffer() = default;
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Buffer() { kFree(data_); }
  /// Grows only: a buffer that is large enough is left alone. What it held is lost when it grows; where there
  /// is no memory, it throws and the buffer is as it was.
  void reserve(std::size_t size) {
    if (size <= size_) return;
    T* const larger = static_cast<T*>(kAlloc(size * sizeof(T)));
    kFree(data_);
    data_ = larger;
    size_ = size;
  }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  void swap(Buffer& other) {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

template <class T>
using HostBuffer = Buffer<T, host_alloc, host_free>;

/// Copies are the named member functions, nothing implicit.
template <class T>
class DeviceBuffer : public Buffer<T, device_alloc, device_free> {
 public:
  /// Waits: the host's memory may go, or be written, at once.
  void from_host(const std::vector<T>& host, Stream s) { from_host(std::span<const T>(host), s); }
  void from_host(std::span<const T> host, Stream s) {
    this->reserve(host.size());
    if (host.empty()) return;
    copy_down(this->data(), host.data(), host.size() * sizeof(T), s);
    synchronise(s);
  }
  std::vector<T> to_host(std::size_t count, Stream s, std::size_t first = 0) const {
    std::vector<T> host(count);
    if (count > 0) copy_up(host.data(), this->data() + first, count * sizeof(T), s);
    synchronise(s);
    return host;
  }
  /// As from_host, where the host needs it no more.
  void take(std::span<const T> host, Stream s) { from_host(host, s); }
  /// As reserve, but what it held is kept.
  void grow(std::size_t size, Stream s) {
    if (size <= this->size()) return;
    DeviceBuffer larger;
    larger.reserve(size);
    if (this->size() > 0) copy_across(larger.data(), this->data(), this->size() * sizeof(T), s);
    synchronise(s);
    this->swap(larger);
  }
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
