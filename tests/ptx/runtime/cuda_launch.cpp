// The part of CUDA's runtime that nvcc's own code calls: kernels and variables are registered when the
// program starts, and `kernel<<<...>>>(...)` is a launch.
#include <cuda_runtime_api.h>

#include <cstring>
#include <string>
#include <unordered_map>

#include "tests/ptx/runtime/launch.h"
#include "tests/ptx/runtime/lock.h"
#include "tests/ptx/runtime/modules.h"
#include "tests/ptx/runtime/names.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/stream.h"

namespace ptx {
namespace {

constexpr std::uint32_t kSharedAtFirst = 48 << 10, kSharedAtMost = 227 << 10;

struct Configuration {
  dim3 blocks, threads;
  std::size_t shared = 0;
  cudaStream_t stream = nullptr;
};
Configuration& configuration() {
  static thread_local Configuration last;
  return last;
}

/// How much dynamic shared memory kernels have been allowed.
std::unordered_map<const Kernel*, std::uint32_t>& allowed_shared() {
  static std::unordered_map<const Kernel*, std::uint32_t> allowed;
  return allowed;
}

Extent extent(const dim3& d) {
  return {d.x, d.y, d.z};
}

void check(const Launch& launch) {
  const Kernel& kernel = *launch.kernel;
  const auto refuse = [&](const std::string& why) {
    fault("launch of " + readable_name(kernel.name) + ": " + why);
  };
  if (launch.blocks.all() == 0 || launch.blocks.x > 2147483647u || launch.blocks.y > 65535 ||
      launch.blocks.z > 65535)
    refuse("a grid of " + text(launch.blocks));
  if (launch.threads.all() == 0 || launch.threads.all() > kernel.max_threads)
    refuse("a block of " + text(launch.threads) + ", where at most " + std::to_string(kernel.max_threads) +
           " are allowed");
  const std::uint32_t shared = kernel.shared_bytes + launch.dynamic_shared;
  const auto allowed = allowed_shared().find(&kernel);
  const bool enough =
      shared <= kSharedAtFirst || (allowed != allowed_shared().end() && shared <= kSharedAtMost &&
                                   launch.dynamic_shared <= allowed->second);
  if (!enough) refuse(std::to_string(shared) + " bytes of shared memory, more than it has been allowed");
}

void start(const void* host, const Configuration& c, void** arguments) {
  const Kernel& kernel = kernel_of(host);
  Launch launch{&kernel, extent(c.blocks), extent(c.threads), static_cast<std::uint32_t>(c.shared), 0, {}};
  check(launch);
  launch.parameters.resize(kernel.parameter_bytes);
  for (std::size_t i = 0; kernel.parameters[i].size > 0; ++i)
    std::memcpy(launch.parameters.data() + kernel.parameters[i].offset, arguments[i],
                kernel.parameters[i].size);
  if (c.stream == nullptr) fault("a launch into the default stream");
  reinterpret_cast<Stream*>(c.stream)->add([launch]() mutable {
    static std::uint32_t launches = 0;
    launch.number = ++launches;
    run_launch(launch);
  });
}

}  // namespace
}  // namespace ptx

extern "C" {

void** __cudaRegisterFatBinary(void*) {
  const ptx::RuntimeLock lock;
  static void* handle = nullptr;
  return &handle;
}
void __cudaRegisterFatBinaryEnd(void**) {}
void __cudaUnregisterFatBinary(void**) {}

void __cudaRegisterFunction(void**, const char* host, char*, const char* name, int, uint3*, uint3*, dim3*,
                            dim3*, int*) {
  const ptx::RuntimeLock lock;
  ptx::register_kernel(host, name);
}

void __cudaRegisterVar(void**, char* host, char*, const char* name, int, std::size_t, int, int) {
  const ptx::RuntimeLock lock;
  ptx::register_symbol(host, name);
}

unsigned __cudaPushCallConfiguration(dim3 blocks, dim3 threads, std::size_t shared, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ptx::configuration() = {blocks, threads, shared, stream};
  return 0;
}

cudaError_t __cudaPopCallConfiguration(dim3* blocks, dim3* threads, std::size_t* shared, void* stream) {
  const ptx::RuntimeLock lock;
  *blocks = ptx::configuration().blocks;
  *threads = ptx::configuration().threads;
  *shared = ptx::configuration().shared;
  *static_cast<cudaStream_t*>(stream) = ptx::configuration().stream;
  return cudaSuccess;
}

/// A kernel's handle is the address that stands for it.
cudaError_t __cudaGetKernel(cudaKernel_t* kernel, const void* host) {
  const ptx::RuntimeLock lock;
  *kernel = static_cast<cudaKernel_t>(const_cast<void*>(host));
  return cudaSuccess;
}

cudaError_t cudaLaunchKernel(const void* host, dim3 blocks, dim3 threads, void** arguments,
                             std::size_t shared, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ptx::start(host, {blocks, threads, shared, stream}, arguments);
  return cudaSuccess;
}

cudaError_t __cudaLaunchKernel(cudaKernel_t kernel, dim3 blocks, dim3 threads, void** arguments,
                               std::size_t shared, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  return cudaLaunchKernel(static_cast<const void*>(kernel), blocks, threads, arguments, shared, stream);
}

cudaError_t cudaLaunchKernelExC(const cudaLaunchConfig_t* config, const void* host, void** arguments) {
  if (config->numAttrs > 0) ptx::fault("a launch with attributes");
  return cudaLaunchKernel(host, config->gridDim, config->blockDim, arguments, config->dynamicSmemBytes,
                          config->stream);
}

cudaError_t cudaFuncSetAttribute(const void* host, cudaFuncAttribute attribute, int value) {
  const ptx::RuntimeLock lock;
  if (attribute == cudaFuncAttributeMaxDynamicSharedMemorySize)
    ptx::allowed_shared()[&ptx::kernel_of(host)] = static_cast<std::uint32_t>(value);
  return cudaSuccess;
}

}  // extern "C"
