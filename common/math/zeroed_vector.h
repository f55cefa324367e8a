// Arrays that are zero where nobody has written.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace parloc {

/// Zeros from calloc: pages of a large array that nobody writes take no memory.
template <class T>
struct ZerosFromCalloc {
  static_assert(std::is_trivially_copyable_v<T>, "zeros are made without a constructor");
  using value_type = T;
  ZerosFromCalloc() = default;
  template <class U>
  ZerosFromCalloc(const ZerosFromCalloc<U>&) {}
  T* allocate(std::size_t count) {
    void* memory = std::calloc(count, sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }
  template <class U>
  void construct(U*) {}  // zero already
  template <class U, class Argument>
  void construct(U* at, Argument&& value) {
    ::new (static_cast<void*>(at)) U(std::forward<Argument>(value));
  }
  bool operator==(const ZerosFromCalloc&) const = default;
};
template <class T>
using ZeroedVector = std::vector<T, ZerosFromCalloc<T>>;

}  // namespace parloc
