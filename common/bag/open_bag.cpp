#include "common/bag/open_bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bag/bag_folder.h"
#include "common/bag/bytes/byte_stream.h"
#include "common/bag/bytes/decompress.h"
#include "common/bag/bytes/temporary_file.h"
#include "common/bag/mcap_bag.h"
#include "common/bag/mcap_format.h"
#include "common/bag/ros1_bag.h"
#include "common/bag/sqlite_bag.h"
#include "common/error.h"

namespace parloc {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSqlite("SQLite format 3\0", 16);
constexpr std::string_view kRos1("#ROSBAG V");
constexpr std::string_view kRosRecord("#ROSRECORD V");  // before 2008

std::string first_bytes(ByteStream& in) {
  std::string bytes(16, '\0');
  bytes.resize(in.read(bytes.data(), bytes.size()));
  return bytes;
}

bool is_container(std::string_view bytes) {
  return bytes.starts_with(mcap::kMagic) || bytes.starts_with(kSqlite) || bytes.starts_with(kRos1) ||
         bytes.starts_with(kRosRecord);
}

std::unique_ptr<BagReader> open_container(std::unique_ptr<BagFile> file, const std::string& path,
                                          std::string_view bytes) {
  if (bytes.starts_with(mcap::kMagic)) return open_mcap_bag(std::move(file));
  if (bytes.starts_with(kSqlite)) return open_sqlite_bag(path, file->path());
  if (bytes.starts_with(kRos1) || bytes.starts_with(kRosRecord)) return open_ros1_bag(std::move(file));
  throw input_error(file->path(), 0, "expected a bag (ROS 1 2.0, SQLite or MCAP)");
}

std::unique_ptr<BagReader> open_unpacked(const BagFile& file, const std::string& path) {
  const TemporaryFile unpacked;
  const std::uint64_t most = std::max<std::uint64_t>(file.size() * 1000, std::uint64_t{64} << 20);
  const auto in = decompressed(Compression::zstd, file.stream(0, file.size()));
  const std::string begin = first_bytes(*in);
  if (!is_container(begin)) throw input_error(path, 0, "expected a bag in the zstd data");
  std::string cut_off;
  try {
    unpacked.write(begin);
    std::string block(std::size_t{1} << 18, '\0');
    for (std::uint64_t all = 0; const std::size_t got = in->read(block.data(), block.size()); all += got) {
      unpacked.write(std::string_view(block).substr(0, got));
      if (all > most) throw Damage{"unpacks to more than 1000 times its size"};
    }
  } catch (const Damage& damage) {
    cut_off = damage.what;
  }
  auto bag =
      open_container(std::make_unique<BagFile>(unpacked.take_descriptor(), path), unpacked.path(), begin);
  return cut_off.empty() ? std::move(bag) : with_fault(std::move(bag), path + ": " + cut_off);
}

}  // namespace

bool is_bag(const std::string& path) {
  std::error_code none;
  if (fs::is_directory(path, none)) return true;
  if (!fs::is_regular_file(path, none)) return false;
  try {
    const BagFile file(path);
    const std::string bytes = first_bytes(*file.stream(0, 16));
    return is_container(bytes) || is_zstd(bytes);
  } catch (const Damage&) {
    return false;
  } catch (const Error&) {
    return false;
  }
}

std::unique_ptr<BagReader> open_bag(const std::string& path) {
  std::error_code none;
  if (fs::is_directory(path, none)) return open_bag_folder(path);
  auto file = std::make_unique<BagFile>(path);
  try {
    const std::string bytes = first_bytes(*file->stream(0, 16));
    return is_zstd(bytes) ? open_unpacked(*file, path) : open_container(std::move(file), path, bytes);
  } catch (const Damage& damage) {
    throw input_error(path, 0, damage.what);
  }
}

}  // namespace parloc
