#include "tools/shards/shard_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <system_error>

#include "common/error.h"
#include "common/file/bytes.h"

namespace parloc::tools::shards {
namespace {

namespace fs = std::filesystem;

// Magic, version (32 bits), head (text); then for each trial: mark (32 bits), item (64), seconds (double),
// number of bytes (32), the bytes, and the CRC-32 of all from the item on.
constexpr std::string_view kMagic = "parloc shard\n";
constexpr std::uint32_t kVersionOfFile = 1, kTrialMark = 0x4c414954;  // "TIAL"
constexpr std::size_t kBeforeBytes = 4 + 8 + 8 + 4, kAfterBytes = 4;
constexpr std::uint64_t kMostHeadBytes = 1 << 24;

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::string head_bytes(const ShardHead& head) {
  return bytes_of([&](ByteWriter& w) {
    w.put_bytes(kMagic.data(), kMagic.size());
    w.put(kVersionOfFile);
    w.put_text(text_of(head));
  });
}

ShardHead get_head(std::istream& in, std::uint64_t size, const std::string& path) {
  ByteReader r(in, size, path);
  std::string magic(std::min<std::uint64_t>(kMagic.size(), size), ' ');
  r.get_bytes(magic.data(), magic.size());
  if (magic != kMagic) throw input_error(path, 0, "expected the results of a shard");
  const auto version = r.get<std::uint32_t>();
  if (version != kVersionOfFile)
    throw input_error(
        path, 0,
        fmt::format("expected the results of a shard in version {}, found {}", kVersionOfFile, version));
  return head_from_text(r.get_text(), path);
}

/// The next trial; nothing where there is no whole one.
bool get_trial(std::istream& in, std::uint64_t left, StoredTrial& trial, std::string& bytes) {
  if (left < kBeforeBytes + kAfterBytes) return false;
  ByteReader r(in, left, "");
  if (r.get<std::uint32_t>() != kTrialMark) return false;
  const auto item = r.get<std::uint64_t>();
  const auto took_s = r.get<double>();
  const auto size = r.get<std::uint32_t>();
  if (r.left() < size + kAfterBytes) return false;
  bytes.resize(size);
  r.get_bytes(bytes.data(), size);
  trial.item = item, trial.took_s = took_s, trial.size = size;
  const std::string whole = bytes_of([&](ByteWriter& w) {
    w.put(item), w.put(took_s), w.put(size);
    w.put_bytes(bytes.data(), bytes.size());
  });
  return r.get<std::uint32_t>() == checksum(whole);
}

[[noreturn]] void fail(const std::string& path, int error_number) {
  throw Error(ErrorKind::output, fmt::format("{}: cannot be written: {}", path, std::strerror(error_number)));
}

}  // namespace

std::string shard_path(const std::string& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder, ignored) ? folder : (fs::path(folder) / "shard.parloc").string();
}

ShardHead read_shard_head(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw input_error(path, 0, "cannot be read");
  const auto size = static_cast<std::uint64_t>(in.tellg());
  in.seekg(0);
  return get_head(in, size, path);
}

ShardContents read_shard(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw input_error(path, 0, "cannot be read");
  const auto size = static_cast<std::uint64_t>(in.tellg());
  in.seekg(0);
  ShardContents contents;
  contents.head = get_head(in, size, path);
  const std::size_t items = contents.head.items;
  std::uint64_t at = static_cast<std::uint64_t>(in.tellg());
  StoredTrial trial;
  for (std::string bytes; get_trial(in, size - at, trial, bytes);) {
    if (trial.item >= items || trial.item % contents.head.shard.of != contents.head.shard.number - 1)
      throw input_error(path, 0, fmt::format("damaged: trial {} is not of this shard", trial.item));
    trial.offset = at + kBeforeBytes;
    at = trial.offset + trial.size + kAfterBytes;
    contents.trials.push_back(trial);
  }
  contents.whole_bytes = at;
  in.clear();
  // What a killed program leaves is the beginning of a trial.
  contents.damaged = size - at >= kBeforeBytes && [&] {
    in.seekg(static_cast<std::streamoff>(at));
    ByteReader r(in, size - at, path);
    if (r.get<std::uint32_t>() != kTrialMark) return true;
    r.get<std::uint64_t>(), r.get<double>();
    return size - at >= kBeforeBytes + r.get<std::uint32_t>() + kAfterBytes;
  }();
  return contents;
}

ShardFile::ShardFile(const std::string& folder, const ShardHead& head)
    : path_(shard_path(folder)), head_(head), there_(head.items, false) {
  std::error_code error;
  fs::create_directories(folder, error);
  descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail(path_, errno);
  try {
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0)
      throw Error(ErrorKind::output, path_ + ": another parloc is at work on this shard");
    if (fs::file_size(path_) == 0) {
      write(head_bytes(head_));
      return;
    }
    const ShardContents contents = read_shard(path_);
    const std::string why = difference(contents.head, path_, head_, "this command");
    if (!why.empty() || contents.head.shard.number != head_.shard.number)
      throw input_error(path_, 0,
                        "holds results of another run: " +
                            (why.empty() ? fmt::format("shard {}", contents.head.shard.number) : why));
    for (const StoredTrial& trial : contents.trials) there_[trial.item] = true;
    size_ = contents.whole_bytes;
    if (ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) fail(path_, errno);
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

ShardFile::~ShardFile() {
  close(descriptor_);
}

std::vector<std::size_t> ShardFile::missing() const {
  std::vector<std::size_t> items = head_.shard.items(head_.items);
  std::erase_if(items, [&](std::size_t item) { return there_[item]; });
  return items;
}

void ShardFile::write(std::string_view bytes) {
  std::uint64_t at = size_;
  for (std::string_view rest = bytes; !rest.empty();) {
    const ssize_t written = pwrite(descriptor_, rest.data(), rest.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int error_number = errno;
      if (ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) { /* the next run drops the beginning */
      }
      fail(path_, error_number);
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
    at += static_cast<std::uint64_t>(written);
  }
  size_ = at;
}

void ShardFile::add(std::size_t item, double took_s, std::string_view bytes) {
  const std::string whole = bytes_of([&](ByteWriter& w) {
    w.put(std::uint64_t{item}), w.put(took_s), w.put(static_cast<std::uint32_t>(bytes.size()));
    w.put_bytes(bytes.data(), bytes.size());
  });
  const std::string framed = bytes_of([&](ByteWriter& w) {
    w.put(kTrialMark);
    w.put_bytes(whole.data(), whole.size());
    w.put(checksum(whole));
  });
  const std::lock_guard lock(mutex_);
  write(framed);
  there_[item] = true;
}

}  // namespace parloc::tools::shards
