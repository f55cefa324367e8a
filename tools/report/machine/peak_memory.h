// How much memory this program has taken.
#pragma once

#include <cstddef>
#include <fstream>
#include <optional>
#include <string>

namespace parloc::tools {

/// Resident, at most so far; nothing where the system does not say (proc(5), VmHWM).
inline std::optional<std::size_t> peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::size_t kib = 0;
  while (status >> word)
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  return std::nullopt;
}

}  // namespace parloc::tools
