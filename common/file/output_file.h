// Writing a result so that it is there as a whole or not at all.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace parloc {

/// Writes `bytes` to a temporary file beside `path`, then renames it to `path`. Throws Error{output} naming
/// the path and the reason; what was at `path` stays, the temporary file does not.
void replace_file(const std::string& path, std::string_view bytes);

/// The same bit by bit, for what is too large to be in memory twice or must outlast a loss of power.
class FileReplacement {
 public:
  /// Throws Error{output}, as all do.
  explicit FileReplacement(const std::string& path);
  ~FileReplacement();  ///< Leaves `path` as it was, unless committed.
  FileReplacement(const FileReplacement&) = delete;
  FileReplacement& operator=(const FileReplacement&) = delete;
  void write(const void* data, std::size_t size);
  /// Everything is on the disk, then at `path`.
  void commit();

 private:
  std::string path_, temporary_;
  std::FILE* file_;
};

/// Throws what replace_file() would throw where no file can be made: to be asked before something else is
/// written that should not be there alone.
void expect_writable(const std::string& path);

}  // namespace parloc
