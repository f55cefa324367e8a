// `parloc evaluate --families`: drives drawn from ranges, closed loop against bare filter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "tools/shards/sharding.h"

namespace parloc::tools {

/// The command line; what was not given is empty.
struct FamiliesOptions {
  std::vector<std::string> families;               ///< Of these only.
  std::string maps;                                ///< Their folder, "maps".
  std::string log, map, truth, corrupt, duration;  ///< Or a recorded log.
  std::uint64_t first_seed = 1;
  std::size_t trials = 20;
  int jobs = 1;
  Config config{};
  std::string samples{}, out{};
  shards::ShardOptions part{};
  bool json = false, quiet = false;
};

/// Gives the exit code; throws Error. `typed`: the whole command line, for the report.
int evaluate_families(const FamiliesOptions& o, const std::string& typed);

}  // namespace parloc::tools
