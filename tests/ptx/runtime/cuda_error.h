// CUDA's last error, which the calls of every part set.
#pragma once

#include <driver_types.h>

namespace ptx {

/// Keeps it for cudaGetLastError, and returns it.
cudaError_t remember(cudaError_t error);

}  // namespace ptx
