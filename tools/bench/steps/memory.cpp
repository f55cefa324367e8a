#include "tools/bench/steps/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string_view>

#include "common/filter/bins.h"

namespace parloc::tools::bench {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// The number behind `key` in a file of lines "key number ..."; empty if it is not there.
std::optional<std::uint64_t> value_of(const std::string& path, std::string_view key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t digits = line.find_first_of("0123456789", key.size());
    if (digits == std::string::npos) return std::nullopt;
    return std::stoull(line.substr(digits));
  }
  return std::nullopt;
}

std::uint64_t number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  return file >> value ? value : kNoLimit;  // "max": no limit
}

/// Of the control group (version 2), whose page cache can be taken back.
std::uint64_t left_in_group() {
  std::ifstream membership("/proc/self/cgroup");
  std::string line;
  if (!std::getline(membership, line) || line.rfind("0::", 0) != 0) return kNoLimit;
  const std::string group = "/sys/fs/cgroup" + line.substr(3);
  const std::uint64_t limit = number_in(group + "/memory.max");
  const std::uint64_t used = number_in(group + "/memory.current");
  if (limit == kNoLimit || used == kNoLimit) return kNoLimit;
  const std::uint64_t cache = value_of(group + "/memory.stat", "inactive_file ").value_or(0);
  const std::uint64_t taken = used - std::min(used, cache);
  return limit - std::min(limit, taken);
}

/// Of the address space (ulimit -v).
std::uint64_t left_in_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  if (!(file >> pages)) return kNoLimit;
  const std::uint64_t taken = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, taken);
}

std::string gigabytes(std::uint64_t bytes) {
  return fmt::format("{:.2f} GB", 1e-9 * static_cast<double>(bytes));
}

}  // namespace

std::optional<std::uint64_t> available_bytes() {
  const std::optional<std::uint64_t> kilobytes = value_of("/proc/meminfo", "MemAvailable:");
  const std::uint64_t free = kilobytes ? 1024 * *kilobytes : kNoLimit;
  const std::uint64_t least = std::min({free, left_in_group(), left_in_address_space()});
  return least == kNoLimit ? std::nullopt : std::optional<std::uint64_t>(least);
}

std::uint64_t needed_bytes(const Variant& variant, std::int64_t particles) {
  const auto n = static_cast<std::uint64_t>(particles);
  constexpr std::uint64_t kPose = 4 * sizeof(float), kMapTables = 128 << 20;
  const std::uint64_t cloud = n * kPose;
  if (variant.backend == BackendChoice::cuda) return 2 * cloud + kMapTables;  // the rest is the device's
  const std::uint64_t particle_arrays =
      n * (7 * sizeof(float) + 2 * sizeof(std::uint64_t) + 3 * sizeof(std::uint32_t));
  const std::uint64_t bins = bin_capacity(particles) * (2 * sizeof(std::uint64_t) + sizeof(std::uint32_t));
  return cloud + particle_arrays + bins + kMapTables;  // as common/filter/engine/filter_engine.h allocates
}

std::int64_t particles_in_memory(const Variant& variant, std::int64_t most,
                                 std::optional<std::uint64_t> available) {
  std::int64_t fits = 0;
  for (std::int64_t step = most; step > 0; step /= 2) {
    while (fits + step <= most && too_large(variant, fits + step, available).empty()) fits += step;
  }
  return fits;
}

std::string too_large(const Variant& variant, std::int64_t particles,
                      std::optional<std::uint64_t> available) {
  const std::uint64_t needed = needed_bytes(variant, particles);
  if (!available || needed <= *available) return "";
  return fmt::format("needs {} of memory, {} are available", gigabytes(needed), gigabytes(*available));
}

}  // namespace parloc::tools::bench
