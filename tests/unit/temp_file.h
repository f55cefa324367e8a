// A file that lives as long as the test does.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace parloc::test {

/// Of any file; empty if there is none.
inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class TempFile {
 public:
  /// A file of this content in the system's temporary folder; `name` ends its name.
  explicit TempFile(const std::string& name, const std::string& content = {})
      : path_((std::filesystem::temp_directory_path() /
               ("parloc_" + std::to_string(getpid()) + "_" + std::to_string(next_number()++) + "_" + name))
                  .string()) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  TempFile(const TempFile&) = delete;
  TempFile& operator=(const TempFile&) = delete;
  ~TempFile() {
    std::error_code none;
    std::filesystem::remove(path_, none);
  }
  const std::string& path() const { return path_; }

 private:
  static int& next_number() {
    static int number = 0;
    return number;
  }
  std::string path_;
};

}  // namespace parloc::test
