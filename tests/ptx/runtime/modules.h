// Kernels and variables by what the host's code has in their place.
#pragma once

#include "tests/ptx/device/thread.h"

namespace ptx {

/// The host's stand-in for a kernel or a variable, and its name in the PTX: told when the program starts.
void register_kernel(const void* host, const char* name);
void register_symbol(const void* host, const char* name);
/// Ends the program where there is none.
const Kernel& kernel_of(const void* host);
const Symbol& symbol_of(const void* host);

}  // namespace ptx
