#include "common/file/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/error.h"

namespace parloc {
namespace {

[[noreturn]] void fail(const std::string& path, int error_number) {
  throw Error(ErrorKind::output, path + ": cannot be written: " + std::strerror(error_number));
}

/// 0, or the errno of what failed. Checks the close too: a full disk may only show there.
int write_whole(const std::string& path, std::string_view bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return errno;
  int error_number = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) error_number = errno;
  if (std::fclose(file) != 0 && error_number == 0) error_number = errno;
  return error_number;
}

// The process id keeps two runs that write the same result apart.
std::string temporary_of(const std::string& path) {
  return path + ".part" + std::to_string(getpid());
}

}  // namespace

void replace_file(const std::string& path, std::string_view bytes) {
  const std::string temporary = temporary_of(path);
  int error_number = write_whole(temporary, bytes);
  if (error_number == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error_number = errno;
  if (error_number == 0) return;
  std::remove(temporary.c_str());
  fail(path, error_number);
}

FileReplacement::FileReplacement(const std::string& path)
    : path_(path), temporary_(temporary_of(path)), file_(std::fopen(temporary_.c_str(), "wb")) {
  if (file_ == nullptr) fail(path_, errno);
}

FileReplacement::~FileReplacement() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::remove(temporary_.c_str());
}

void FileReplacement::write(const void* data, std::size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) fail(path_, errno);
}

void FileReplacement::commit() {
  if (std::fflush(file_) != 0 || fsync(fileno(file_)) != 0) fail(path_, errno);
  const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
  if (closed && std::rename(temporary_.c_str(), path_.c_str()) == 0) return;
  const int error_number = errno;
  std::remove(temporary_.c_str());
  fail(path_, error_number);
}

GrowingFile::GrowingFile(const std::string& path)
    : path_(path),
      is_new_(access(path.c_str(), F_OK) != 0),
      descriptor_(open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) fail(path_, errno);
}

GrowingFile::~GrowingFile() {
  close(descriptor_);
  if (is_new_ && size_ == 0) std::remove(path_.c_str());
}

void GrowingFile::append(std::string_view bytes) {
  // A device or a pipe has no length to take away.
  if (size_ == 0 && ftruncate(descriptor_, 0) != 0 && errno != EINVAL) fail(path_, errno);
  size_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void expect_writable(const std::string& path) {
  const std::string temporary = temporary_of(path);
  int error_number = write_whole(temporary, "");
  std::remove(temporary.c_str());
  std::error_code ignored;
  if (error_number == 0 && std::filesystem::is_directory(path, ignored)) error_number = EISDIR;
  if (error_number != 0) fail(path, error_number);
}

}  // namespace parloc
