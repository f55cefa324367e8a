#include "tools/compare/entry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/error.h"
#include "tools/program/parse_number.h"

namespace parloc::tools::compare {
namespace {

/// What stands before `mark`; what stands after it is left in `rest`, which is empty without a mark.
std::string before(const std::string& text, char mark, std::string& rest, const std::string& whole) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) return text;
  rest = text.substr(at + 1);
  if (rest.empty())
    throw Error(ErrorKind::usage, fmt::format("--filters: '{}': expected something after '{}'", whole, mark));
  return text.substr(0, at);
}

std::int64_t number_of(const std::string& particles, const std::string& whole) {
  std::int64_t number{};
  const char* const last = particles.data() + particles.size();
  const auto [end, status] = std::from_chars(particles.data(), last, number);
  if (status != std::errc() || end != last)
    throw Error(
        ErrorKind::usage,
        fmt::format("--filters: '{}': expected a whole number of particles, got '{}'", whole, particles));
  return number;  // its size is judged with the rest of the configuration
}

Entry read_entry(const std::string& text, const Config& base) {
  std::string config_file, particles;
  Entry e;
  e.kind = before(before(text, '=', config_file, text), '@', particles, text);
  if (std::find(kPoseFilterNames.begin(), kPoseFilterNames.end(), e.kind) == kPoseFilterNames.end())
    throw Error(ErrorKind::usage, fmt::format("--filters: expected one of {}, got '{}'",
                                              fmt::join(kPoseFilterNames, " "), e.kind));
  e.label = e.kind;
  if (!config_file.empty()) e.label += ":" + std::filesystem::path(config_file).stem().string();
  e.config = config_file.empty() ? base : read_config(config_file, base);
  if (!particles.empty()) {
    if (e.kind == "amcl" || e.kind == "ekf" || e.kind == "ekf_beams")
      throw Error(ErrorKind::usage, fmt::format("--filters: '{}': {} takes no number of particles", text,
                                                e.kind == "amcl" ? "amcl chooses its own and" : e.kind));
    e.label += "@" + particles;
    e.config.particles = number_of(particles, text);
    e.config.min_particles = e.config.max_particles = 0;
  }
  e.config.threads = 1;
  try {
    validate(e.config);
  } catch (const Error& error) {  // a file is sound by now, so it is the command line
    throw Error(ErrorKind::usage, fmt::format("--filters: '{}': {}", text, error.what()));
  }
  return e;
}

}  // namespace

std::vector<Entry> read_entries(const std::string& list, const Config& base) {
  std::vector<Entry> entries;
  for (const std::string& text : split_at_commas(list)) {
    const Entry e = read_entry(text, base);
    if (std::any_of(entries.begin(), entries.end(), [&](const Entry& o) { return o.label == e.label; }))
      throw Error(ErrorKind::usage, fmt::format("--filters: '{}' is there twice", e.label));
    entries.push_back(e);
  }
  return entries;
}

}  // namespace parloc::tools::compare
