// Relaxed atomics on integers, for the device and the host alike. Only for results that do not depend on the
// order: sums, maxima, and inserting a key.
#pragma once

#include <cstdint>

#include "common/math/host_device.h"

namespace parloc {

PARLOC_HD std::uint64_t atomic_add(std::uint64_t* at, std::uint64_t value) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(reinterpret_cast<unsigned long long*>(at), static_cast<unsigned long long>(value));
#else
  return __atomic_fetch_add(at, value, __ATOMIC_RELAXED);
#endif
}

PARLOC_HD std::uint32_t atomic_add(std::uint32_t* at, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(at, value);
#else
  return __atomic_fetch_add(at, value, __ATOMIC_RELAXED);
#endif
}

/// Stores `desired` if *at is `expected`; returns what was there.
template <class T>
PARLOC_HD T atomic_swap_if(T* at, T expected, T desired) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(T) == 8)
    return atomicCAS(reinterpret_cast<unsigned long long*>(at), static_cast<unsigned long long>(expected),
                     static_cast<unsigned long long>(desired));
  else
    return atomicCAS(at, expected, desired);
#else
  __atomic_compare_exchange_n(at, &expected, desired, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
  return expected;
#endif
}

template <class T>
PARLOC_HD T atomic_read(const T* at) {
#if defined(__CUDA_ARCH__)
  return *static_cast<const volatile T*>(at);
#else
  return __atomic_load_n(at, __ATOMIC_RELAXED);
#endif
}

/// Where several write, and all the same.
template <class T>
PARLOC_HD void atomic_write(T* at, T value) {
#if defined(__CUDA_ARCH__)
  *static_cast<volatile T*>(at) = value;
#else
  __atomic_store_n(at, value, __ATOMIC_RELAXED);
#endif
}

/// *at = max(*at, value).
template <class T>
PARLOC_HD void atomic_raise(T* at, T value) {
#if defined(__CUDA_ARCH__)
  if constexpr (sizeof(T) == 8)
    atomicMax(reinterpret_cast<unsigned long long*>(at), static_cast<unsigned long long>(value));
  else
    atomicMax(at, value);
#else
  T seen = atomic_read(at);
  while (seen < value) {
    const T before = atomic_swap_if(at, seen, value);
    if (before == seen) return;
    seen = before;
  }
#endif
}

}  // namespace parloc
