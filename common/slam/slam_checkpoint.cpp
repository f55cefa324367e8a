#include "common/slam/slam_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/bytes.h"
#include "common/settings/read_settings.h"
#include "common/slam/checkpoint_values.h"
#include "common/slam/slam_backend.h"
#include "common/slam/slam_settings.h"

namespace parloc {
namespace {

// Magic, version (32 bits), content, SHA-256 of all that in hexadecimal.
constexpr std::string_view kMagic = "parloc slam checkpoint\n";
/// To be raised with every change of what is written, here and in GridSlam.
constexpr std::uint32_t kVersion = 6;
constexpr std::size_t kHeadBytes = kMagic.size() + sizeof kVersion;
constexpr std::size_t kChecksumBytes = 64;

std::unique_ptr<std::istream> opened_file(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status))
    throw input_error(path, 0, "expected a checkpoint, found a folder");
  errno = 0;
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file) throw input_error(path, 0, std::string("cannot be opened: ") + std::strerror(errno));
  return file;
}

std::string checksum_of(std::istream& in, std::uint64_t size) {
  Sha256 sha;
  std::vector<char> block(std::size_t{1} << 20);
  while (size > 0 && in) {
    in.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(size, block.size())));
    sha.add(block.data(), static_cast<std::size_t>(in.gcount()));
    size -= static_cast<std::uint64_t>(in.gcount());
  }
  return sha.hex();
}

/// Where the content begins, and how long it is: only of a file that is whole.
std::uint64_t seek_content(std::istream& in, const std::string& name) {
  in.seekg(0, std::ios::end);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in.tellg()));
  in.seekg(0);
  std::string magic(kMagic.size(), '\0');
  if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kMagic)
    throw input_error(name, 0, "expected a checkpoint of parloc slam");
  if (size < kHeadBytes + kChecksumBytes) throw input_error(name, 0, "the checkpoint is cut short");
  const auto version = ByteReader(in, sizeof kVersion, name).get<std::uint32_t>();
  if (version != kVersion)
    throw input_error(name, 0,
                      fmt::format("expected a checkpoint of version {}, found {}: made by {} parloc",
                                  kVersion, version, version > kVersion ? "a newer" : "an older"));
  in.seekg(0);
  const std::string sum = checksum_of(in, size - kChecksumBytes);
  std::string written(kChecksumBytes, '\0');
  in.read(written.data(), kChecksumBytes);
  if (!in || written != sum)
    throw input_error(name, 0, "the checkpoint is damaged or cut short: its checksum does not fit");
  in.seekg(kHeadBytes);
  return size - kHeadBytes - kChecksumBytes;
}

}  // namespace

SlamCheckpoint::SlamCheckpoint(const std::string& path) : name_(path) {
  open(opened_file(path));
}
SlamCheckpoint::SlamCheckpoint(std::string bytes, const std::string& name) : name_(name) {
  open(std::make_unique<std::istringstream>(std::move(bytes), std::ios::binary));
}
SlamCheckpoint::~SlamCheckpoint() = default;
SlamCheckpoint::SlamCheckpoint(SlamCheckpoint&&) noexcept = default;
SlamCheckpoint& SlamCheckpoint::operator=(SlamCheckpoint&&) noexcept = default;

void SlamCheckpoint::open(std::unique_ptr<std::istream> in) {
  in_ = std::move(in);
  const std::uint64_t size = seek_content(*in_, name_);
  rest_ = std::make_unique<ByteReader>(*in_, size, name_);
  try {
    const YamlSection top(rest_->get_text(), name_, {"settings", 64 * 1024, ErrorKind::input});
    read_settings(top, settings_of(saved_config_));
    top.finish();
    validate(saved_config_);
    bind_propose_rules(saved_config_.slam);  // refuses what a backend would
  } catch (const Error& e) {
    throw Error(ErrorKind::input, e.what());
  }
  config = saved_config_;
  own = rest_->get_text();
}

void put_checkpoint_begin(ByteWriter& w) {
  w.put_bytes(kMagic.data(), kMagic.size());
  w.put(kVersion);
}

void put_checkpoint_end(ByteWriter& w) {
  const std::string sum = w.sha256();
  w.put_bytes(sum.data(), sum.size());
  w.flush();
}

}  // namespace parloc
