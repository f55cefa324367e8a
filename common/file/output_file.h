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

/// A file that is there while it grows, for who looks at it meanwhile, and stays whatever becomes of this
/// run.
class GrowingFile {
 public:
  /// Throws Error{output}, as all do. What was at `path` stays until the first write.
  explicit GrowingFile(const std::string& path);
  ~GrowingFile();  ///< Leaves nothing new where nothing was written.
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  void append(std::string_view bytes);
  std::size_t size() const { return size_; }

 private:
  std::string path_;
  bool is_new_;
  int descriptor_;
  std::size_t size_ = 0;
};

/// Throws what replace_file() would throw where no file can be made: to be asked before something else is
/// written that should not be there alone.
void expect_writable(const std::string& path);

}  // namespace parloc
