// The part of CUDA's runtime that asks about the device, and errors.
#include <cuda_runtime_api.h>

#include <cstring>

#include "tests/ptx/runtime/cuda_error.h"
#include "tests/ptx/runtime/modules.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

// A device of compute capability 9.0, the one that the PTX was made for: CUB chooses its kernels by it.
constexpr int kMajor = 9, kProcessors = 132;
thread_local cudaError_t last_error = cudaSuccess;

}  // namespace

cudaError_t remember(cudaError_t error) {
  last_error = error;
  return error;
}

}  // namespace ptx

extern "C" {

cudaError_t cudaGetLastError() {
  const cudaError_t error = ptx::last_error;
  ptx::last_error = cudaSuccess;
  return error;
}

cudaError_t cudaPeekAtLastError() {
  return ptx::last_error;
}

const char* cudaGetErrorName(cudaError_t error) {
  return error == cudaErrorMemoryAllocation ? "cudaErrorMemoryAllocation" : "cudaError";
}

const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaErrorMemoryAllocation ? "out of memory" : "an error";
}

cudaError_t cudaGetDeviceCount(int* count) {
  *count = 1;
  return cudaSuccess;
}

cudaError_t cudaGetDevice(int* device) {
  *device = 0;
  return cudaSuccess;
}

cudaError_t cudaSetDevice(int device) {
  return device == 0 ? cudaSuccess : ptx::remember(cudaErrorInvalidDevice);
}

cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
  std::memset(properties, 0, sizeof *properties);
  std::strcpy(properties->name, "PTX on the host");
  properties->major = ptx::kMajor;
  properties->multiProcessorCount = ptx::kProcessors;
  properties->totalGlobalMem = ptx::settings().memory;
  return cudaSuccess;
}

cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int) {
  switch (attribute) {
    case cudaDevAttrComputeCapabilityMajor:
      *value = ptx::kMajor;
      break;
    case cudaDevAttrMultiProcessorCount:
      *value = ptx::kProcessors;
      break;
    case cudaDevAttrMaxGridDimX:
      *value = 2147483647;
      break;
    default:
      *value = 0;
  }
  return cudaSuccess;
}

cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* attributes, const void* function) {
  const ptx::Kernel& kernel = ptx::kernel_of(function);
  std::memset(attributes, 0, sizeof *attributes);
  attributes->ptxVersion = attributes->binaryVersion = ptx::kMajor * 10;
  attributes->maxThreadsPerBlock = static_cast<int>(kernel.max_threads);
  attributes->sharedSizeBytes = kernel.shared_bytes;
  attributes->localSizeBytes = kernel.local_bytes;
  return cudaSuccess;
}

cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(int* blocks, const void*, int, std::size_t,
                                                                   unsigned) {
  *blocks = 2;
  return cudaSuccess;
}

}  // extern "C"
