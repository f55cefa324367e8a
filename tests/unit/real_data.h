// Where the real logs are, for tests that measure against them when they are there.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace parloc::test {

/// $PARLOC_DATA/<file>, or ../shared/data/<file>; the file need not exist.
inline std::string real_data(const std::string& file) {
  const char* root = std::getenv("PARLOC_DATA");
  return std::string(root != nullptr && *root != '\0' ? root : "../shared/data") + "/" + file;
}

inline bool exists(const std::string& path) {
  std::error_code none;
  return std::filesystem::exists(path, none);
}

}  // namespace parloc::test

/// In a test: ends it as skipped, saying why, unless the file is there.
#define PARLOC_NEEDS_FILE(path) \
  if (!parloc::test::exists(path)) GTEST_SKIP() << path << " is not here (set PARLOC_DATA)"
