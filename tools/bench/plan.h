// What the user wants to be measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/bench/steps/scenes.h"
#include "tools/bench/steps/variants.h"

namespace parloc::tools::bench {

struct Plan {
  std::vector<std::string> scenes;
  std::vector<Cloud> clouds;
  std::vector<Algorithm> algorithms;
  int threads = 0;  ///< 0: all cores.
  std::int64_t max_particles = 0;
  int max_beams = 0;
  bool quick = false;
};

/// Those of `values` that are not above `most`.
template <class Value>
std::vector<Value> at_most(std::vector<Value> values, Value most) {
  std::erase_if(values, [&](const Value& value) { return value > most; });
  return values;
}

}  // namespace parloc::tools::bench
