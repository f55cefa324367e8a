#include "common/file/input_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/error.h"

namespace parloc {

namespace fs = std::filesystem;

std::string read_input_file(const std::string& path, const std::string& where, std::uintmax_t longest) {
  const auto fail = [&](const std::string& reason) { throw Error(ErrorKind::input, where + ": " + reason); };
  std::error_code status;
  const bool regular = fs::is_regular_file(path, status);
  if (status) fail("cannot be opened: " + status.message());
  if (!regular) fail("cannot be read: expected a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(std::string("cannot be opened: ") + std::strerror(errno));
  const std::uintmax_t size = fs::file_size(path, status);
  if (status) fail("cannot be read: " + status.message());
  std::string bytes(static_cast<std::size_t>(std::min(size, longest)), '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<std::size_t>(file.gcount()) != bytes.size()) {
    fail(fmt::format("cannot be read: expected {} bytes, found {}", bytes.size(), file.gcount()));
  }
  return bytes;
}

}  // namespace parloc
