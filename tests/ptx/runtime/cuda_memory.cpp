// The part of CUDA's runtime that allocates and copies. Ranges and kinds of memory are checked at the call. A
// copy of pageable memory may be done at any time until the stream is waited for: it is done as late as that,
// and finds out whether the host changed its buffer, or gave it away, before then.
#include <cuda_runtime_api.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tests/ptx/runtime/cuda_error.h"
#include "tests/ptx/runtime/device_memory.h"
#include "tests/ptx/runtime/lock.h"
#include "tests/ptx/runtime/modules.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"
#include "tests/ptx/runtime/stream.h"

namespace ptx {
namespace {

constexpr int kPoison = 0xCD;

/// Page-locked memory: where it begins, and its size.
std::map<const char*, std::size_t>& pinned() {
  static std::map<const char*, std::size_t> pieces;
  return pieces;
}

bool is_pinned(const void* at, std::size_t bytes) {
  const auto* first = static_cast<const char*>(at);
  auto piece = pinned().upper_bound(first);
  if (piece == pinned().begin()) return false;
  --piece;
  return first + bytes <= piece->first + piece->second;
}

/// Whether this allocation is the one that is to fail.
bool fails_now() {
  return ++host_counts().allocations == settings().failing;
}

std::uint64_t number(const void* address) {
  return reinterpret_cast<std::uint64_t>(address);
}

Stream& stream_of(cudaStream_t stream) {
  if (stream == nullptr) fault("work for the default stream");
  return *reinterpret_cast<Stream*>(stream);
}

void check_side(const void* at, std::size_t bytes, bool on_device, const char* what) {
  const DeviceMemory& memory = DeviceMemory::instance();
  if (!on_device && memory.is_device(number(at)))
    fault(std::string("a copy ") + what + " memory of the host is given memory of the device");
  if (on_device && !memory.holds(number(at), bytes))
    fault(std::string("a copy ") + what + " the device: " + memory.explain(number(at), bytes));
}

std::size_t hash_of(const void* at, std::size_t bytes) {
  return std::hash<std::string_view>{}({static_cast<const char*>(at), bytes});
}

/// The work of a copy whose addresses are those of the host's bytes.
Work copy_work(void* to, const void* from, std::size_t bytes, const void* pageable) {
  if (pageable == nullptr) return [=] { std::memcpy(to, from, bytes); };
  const std::size_t before = hash_of(pageable, bytes);
  return [=] {
    if (hash_of(pageable, bytes) != before)
      fault("the host changed or freed its buffer of " + std::to_string(bytes) +
            " bytes before the copy was waited for");
    std::memcpy(to, from, bytes);
  };
}

void copy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, Stream& stream) {
  const bool to_device = kind == cudaMemcpyHostToDevice || kind == cudaMemcpyDeviceToDevice;
  const bool from_device = kind == cudaMemcpyDeviceToHost || kind == cudaMemcpyDeviceToDevice;
  if (!to_device && !from_device) fault("a copy of a kind that is not understood");
  check_side(to, bytes, to_device, "to");
  check_side(from, bytes, from_device, "from");
  ++host_counts().copies;
  host_counts().bytes_copied += bytes;

  const void* host = to_device ? from : to;
  const bool pageable = to_device != from_device && !is_pinned(host, bytes);
  if (pageable && stream.is_recording()) fault("a copy of pageable memory is recorded");
  DeviceMemory& memory = DeviceMemory::instance();
  if (to_device) to = memory.bytes_at(number(to));
  if (from_device) from = memory.bytes_at(number(from));
  if (pageable && !settings().late_copies) stream.run();
  const Work work = copy_work(to, from, bytes, pageable ? host : nullptr);
  stream.add(work);
  if (pageable && !settings().late_copies) stream.run();
}

}  // namespace
}  // namespace ptx

extern "C" {

cudaError_t cudaMalloc(void** at, std::size_t bytes) {
  const ptx::RuntimeLock lock;
  ptx::Stream::forbid_while_recording("memory is allocated");
  *at = nullptr;
  if (ptx::fails_now()) return ptx::remember(cudaErrorMemoryAllocation);
  if (bytes == 0) return cudaSuccess;
  const std::uint64_t address = ptx::DeviceMemory::instance().allocate(bytes);
  if (address == 0) return ptx::remember(cudaErrorMemoryAllocation);
  *at = reinterpret_cast<void*>(address);
  return cudaSuccess;
}

cudaError_t cudaFree(void* at) {
  const ptx::RuntimeLock lock;
  if (at == nullptr) return cudaSuccess;
  ptx::Stream::forbid_while_recording("memory is freed");
  ptx::Stream::run_all();
  if (!ptx::DeviceMemory::instance().free(ptx::number(at)))
    ptx::fault("cudaFree of what is no live allocation");
  return cudaSuccess;
}

cudaError_t cudaMallocHost(void** at, std::size_t bytes) {
  const ptx::RuntimeLock lock;
  ptx::Stream::forbid_while_recording("memory is allocated");
  *at = nullptr;
  if (ptx::fails_now()) return ptx::remember(cudaErrorMemoryAllocation);
  if (bytes == 0) return cudaSuccess;
  *at = std::malloc(bytes);
  std::memset(*at, ptx::kPoison, bytes);
  ptx::pinned()[static_cast<char*>(*at)] = bytes;
  return cudaSuccess;
}

cudaError_t cudaFreeHost(void* at) {
  const ptx::RuntimeLock lock;
  if (at == nullptr) return cudaSuccess;
  ptx::Stream::forbid_while_recording("memory is freed");
  ptx::Stream::run_all();
  if (ptx::pinned().erase(static_cast<char*>(at)) == 0)
    ptx::fault("cudaFreeHost of what is no live allocation");
  std::free(at);
  return cudaSuccess;
}

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                            cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ptx::copy(to, from, bytes, kind, ptx::stream_of(stream));
  return cudaSuccess;
}

cudaError_t cudaMemcpyToSymbolAsync(const void* symbol, const void* from, std::size_t bytes,
                                    std::size_t offset, cudaMemcpyKind kind, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  const std::uint64_t to = ptx::symbol_of(symbol).address + offset;
  ptx::copy(reinterpret_cast<void*>(to), from, bytes, kind, ptx::stream_of(stream));
  return cudaSuccess;
}

cudaError_t cudaMemsetAsync(void* at, int value, std::size_t bytes, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ptx::check_side(at, bytes, true, "to");
  char* to = ptx::DeviceMemory::instance().bytes_at(ptx::number(at));
  ptx::stream_of(stream).add([=] { std::memset(to, value, bytes); });
  return cudaSuccess;
}

}  // extern "C"
