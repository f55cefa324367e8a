// A file that is gone when its last user is.
#pragma once

#include <string>
#include <string_view>

namespace parloc {

/// In TMPDIR or /tmp. It has a name until this is destroyed, and content as long as it is open.
class TemporaryFile {
 public:
  /// Throws Error{output}, as write() does.
  TemporaryFile();
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void write(std::string_view bytes) const;
  const std::string& path() const { return path_; }
  /// Another descriptor of it, to be closed by the caller.
  int take_descriptor() const;

 private:
  std::string path_;
  int descriptor_;
};

}  // namespace parloc
