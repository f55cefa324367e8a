// The device that a backend works on.
#pragma once

#include <string>

#include "common/filter/backend.h"
#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Selects it before anything of a backend is allocated.
inline int selected(int device) {
  select_device(device);
  return device;
}

#if defined(__CUDACC__)
/// Its name. Throws Error{backend} if there is no such device.
inline std::string usable_device(int device) {
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
#endif

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
