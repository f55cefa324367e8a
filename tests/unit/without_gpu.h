// For tests that need a GPU, and skip where there is none.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "common/error.h"

namespace parloc::test {

inline bool gpu_is_required() {
  const char* required = std::getenv("PARLOC_REQUIRE_GPU");
  return required != nullptr && std::string_view(required) == "1";
}

}  // namespace parloc::test

/// In a test: does what needs a GPU. Where none answers, ends the test as skipped, saying why; as failed if
/// PARLOC_REQUIRE_GPU is 1, or if it was another error.
#define PARLOC_NEEDS_GPU(...)                                                          \
  try {                                                                                \
    __VA_ARGS__;                                                                       \
  } catch (const parloc::Error& error) {                                               \
    if (error.kind() != parloc::ErrorKind::backend || parloc::test::gpu_is_required()) \
      FAIL() << error.what();                                                          \
    GTEST_SKIP() << error.what();                                                      \
  }                                                                                    \
  static_assert(true, "so that a semicolon follows")
