// What can be chosen from outside, by environment variables.
#pragma once

#include <cstdint>
#include <string>

namespace ptx {

struct Settings {
  std::uint32_t seed;       ///< PTX_SEED: the order of blocks and threads; 0: as they are numbered
  bool races;               ///< PTX_RACES=0: without the race detector
  bool late_copies;         ///< PTX_LATE_COPIES=1: copies of pageable memory wait like all other work
  std::uint64_t memory;     ///< PTX_MEMORY_MB: how much device memory there is
  std::uint64_t failing;    ///< PTX_FAIL_ALLOCATION=k: the k-th allocation, counted from 1, fails
  std::string known_races;  ///< PTX_KNOWN_RACES: a file of races that do not fail (tests/ptx/known_races.txt)
  bool report;              ///< PTX_REPORT=1: what every kernel did, at the end
};
/// As the environment says when it is first asked for; tests may change it.
Settings& settings();

}  // namespace ptx
