#include "common/bag/bytes/temporary_file.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "common/error.h"

namespace parloc {

namespace {
Error cannot_write(const std::string& path) {
  return file_error(ErrorKind::output, path, 0, std::string("cannot be written: ") + std::strerror(errno));
}
}  // namespace

TemporaryFile::TemporaryFile() {
  std::error_code none;
  std::filesystem::path folder = std::filesystem::temp_directory_path(none);
  if (none) folder = "/tmp";
  path_ = (folder / "parloc-XXXXXX").string();
  descriptor_ = ::mkostemp(path_.data(), O_CLOEXEC);
  if (descriptor_ < 0) throw cannot_write(path_);
}

TemporaryFile::~TemporaryFile() {
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

void TemporaryFile::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw cannot_write(path_);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

int TemporaryFile::take_descriptor() const {
  return ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
}

}  // namespace parloc
