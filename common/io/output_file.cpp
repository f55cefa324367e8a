#include "common/io/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

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

}  // namespace

void replace_file(const std::string& path, std::string_view bytes) {
  // The process id keeps two runs that write the same result apart.
  const std::string temporary = path + ".part" + std::to_string(getpid());
  int error_number = write_whole(temporary, bytes);
  if (error_number == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error_number = errno;
  if (error_number == 0) return;
  std::remove(temporary.c_str());
  fail(path, error_number);
}

}  // namespace parloc
