// Loads, stores and atomics of the written kernels. Every one is checked (runtime/access.cpp) before the
// memory is touched.
#pragma once

#include <cstring>
#include <type_traits>

#include "tests/ptx/device/arithmetic.h"
#include "tests/ptx/device/thread.h"

namespace ptx {

// Addresses are numbers of the device. Those of shared memory, local memory and parameters are offsets, which
// in the generic space get one of these added. Global and constant memory have generic addresses from the
// start.
inline constexpr std::uint64_t kSharedWindow = 1ull << 60, kLocalWindow = 2ull << 60,
                               kParameterWindow = 3ull << 60, kWindowBits = 7ull << 60;

enum class Space { global, shared, local, parameter, generic };
enum class Access { read, write, strong_read, strong_write, update };

/// Where the memory is on the host. Ends the program with one line if the access is not allowed.
char* reach(Thread& thread, Space space, std::uint64_t address, unsigned bytes, Access access);
/// Orders what the thread did before with what it does after, for other blocks too unless it is of the block.
void fence(Thread& thread);
/// float32 in global memory: subnormal numbers count as zero, before and after.
inline float add_flushed(float a, float b) {
  const auto flushed = [](float x) {
    return std::fpclassify(x) == FP_SUBNORMAL ? std::copysign(0.0f, x) : x;
  };
  return flushed(add(flushed(a), flushed(b)));
}
/// Ends the program: this instruction is not understood, or refused.
[[noreturn]] void refuse(const Thread& thread, const char* why);

template <class T>
T take(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
template <class T>
void put(char* to, T value) {
  std::memcpy(to, &value, sizeof value);
}

template <class T>
T exchange(T, T value) {
  return value;
}
template <class T>
T increase(T old, T bound) {
  return old >= bound ? T{0} : static_cast<T>(old + 1);
}
template <class T>
T decrease(T old, T bound) {
  return old == 0 || old > bound ? bound : static_cast<T>(old - 1);
}
template <class T>
T bit_and(T a, T b) {
  return a & b;
}
template <class T>
T bit_or(T a, T b) {
  return a | b;
}
template <class T>
T bit_xor(T a, T b) {
  return a ^ b;
}

/// Replaces what is there by operation(it, value), and returns what was there.
template <class T, class Operation>
T update(Thread& thread, Space space, std::uint64_t address, Operation operation, T value) {
  char* at = reach(thread, space, address, sizeof(T), Access::update);
  const T old = take<T>(at);
  put<T>(at, operation(old, value));
  return old;
}
template <class T>
T compare_and_swap(Thread& thread, Space space, std::uint64_t address, T expected, T desired) {
  char* at = reach(thread, space, address, sizeof(T), Access::update);
  const T old = take<T>(at);
  if (old == expected) put<T>(at, desired);
  return old;
}

/// Asks what a thread wants of its warp.
inline void ask(Thread& thread, Request request, std::uint32_t mask, std::uint64_t value,
                std::uint32_t lane = 0, std::uint32_t bound = 0, bool is_signed = false) {
  thread.meeting = {request, thread.line, mask, value, lane, bound, is_signed, 0, 0, 0, false};
}
/// Waits at a barrier of the block, for all of its threads if `expected` is 0.
inline void await(Thread& thread, Request request, std::uint32_t barrier, std::uint32_t expected,
                  bool predicate) {
  thread.meeting = {request, thread.line, 0, predicate, 0, 0, false, barrier, expected, 0, false};
}

}  // namespace ptx
