// What the program has allocated so far, for tests that a step allocates nothing: link allocation_count.cpp.
#pragma once

#include <cstddef>

namespace parloc::test {

std::size_t allocations();

}  // namespace parloc::test
