// Marks a function for host and device. Keyed on __CUDACC__ (not __CUDA_ARCH__), so that both passes of nvcc
// see one declaration. Always inlined on the host: a hot loop compiled for one instruction set then compiles
// the arithmetic it calls for that set too (cpu/parallel.h).
#pragma once

#if defined(__CUDACC__)
#define PARLOC_HD __host__ __device__ __forceinline__
#else
#define PARLOC_HD inline __attribute__((always_inline))
#endif
