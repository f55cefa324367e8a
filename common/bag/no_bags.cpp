// Stands for the readers of bags in a build without their libraries.
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "common/bag/mcap_format.h"
#include "common/bag/open_bag.h"
#include "common/error.h"

namespace parloc {

bool is_bag(const std::string& path) {
  std::error_code none;
  if (std::filesystem::is_directory(path, none)) return true;
  if (!std::filesystem::is_regular_file(path, none)) return false;
  char begin[8] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof begin);
  const std::string_view bytes(begin, sizeof begin);
  return bytes == mcap::kMagic || bytes == "SQLite f" || bytes == "#ROSBAG " ||
         bytes.starts_with("\x28\xb5\x2f\xfd");
}

std::unique_ptr<BagReader> open_bag(const std::string& path) {
  throw input_error(path, 0,
                    "is a bag, and this parloc reads none: it was built without SQLite, zstd, lz4 or bzip2 "
                    "(docs/building.md)");
}

}  // namespace parloc
