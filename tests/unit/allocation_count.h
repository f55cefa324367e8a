// What the program has allocated so far, for tests that a step allocates nothing: link allocation_count.cpp.
#pragma once

#include <cstddef>

namespace parloc::test {

/// False where a sanitizer's own allocator cannot be replaced (clang's TSan): such tests are then skipped.
bool counts_allocations();
std::size_t allocations();

}  // namespace parloc::test
