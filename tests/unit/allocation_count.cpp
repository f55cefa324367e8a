// Apart from the tests, or the compiler would see through new and delete and warn that they do not match.
#include "tests/unit/allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> count{0};
}

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PARLOC_FOREIGN_ALLOCATOR
#endif
#endif

#ifdef PARLOC_FOREIGN_ALLOCATOR
namespace parloc::test {
bool counts_allocations() {
  return false;
}
}  // namespace parloc::test
#else
void* operator new(std::size_t size) {
  ++count;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size > 0 ? size : 1);
}
void operator delete(void* p, const std::nothrow_t&) noexcept {
  std::free(p);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace parloc::test {
bool counts_allocations() {
  return true;
}
}  // namespace parloc::test
#endif

namespace parloc::test {
std::size_t allocations() {
  return count;
}
}  // namespace parloc::test
