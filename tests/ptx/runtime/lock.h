// CUDA's runtime may be called by several threads. As it is played here, those that start, copy, allocate or
// wait come one after the other.
#pragma once

#include <mutex>

namespace ptx {

class RuntimeLock {
 public:
  RuntimeLock() : lock_(mutex()) {}

 private:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex one;
    return one;
  }
  std::lock_guard<std::recursive_mutex> lock_;
};

}  // namespace ptx
