// Marks a function for host and device. Keyed on __CUDACC__ (not __CUDA_ARCH__), so that both passes of nvcc
// see one declaration. Always inlined on the host: a hot loop compiled for one instruction set then compiles
// the arithmetic it calls for that set too (cpu/parallel.h).
#pragma once

#if defined(__CUDACC__)
#define PARLOC_HD __host__ __device__ __forceinline__
#else
#define PARLOC_HD inline __attribute__((always_inline))
#endif

/// Between these two a switch over an enumeration has a case for every value, or it does not compile: what is
/// added to the enumeration must not run as something else.
#if defined(__GNUC__) && !defined(__CUDACC__)
#define PARLOC_EVERY_CASE _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic error \"-Wswitch\"")
#define PARLOC_EVERY_CASE_END _Pragma("GCC diagnostic pop")
#else
#define PARLOC_EVERY_CASE
#define PARLOC_EVERY_CASE_END
#endif
