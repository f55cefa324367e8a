// One filter of a comparison, with settings of its own.
#pragma once

#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/config/pose_filters.h"

namespace parloc::tools::compare {

struct Entry {
  std::string label;  ///< For people: "edh@100", "amcl:turtlebot3" with a file of its own.
  std::string kind;   ///< One of kPoseFilterNames.
  Config config;
};

/// What is compared if nobody says what.
inline constexpr const char* kDefaultFilters =
    "mcl,amcl,ekf,ekf_beams,edh@100,naedh@100,ledh@100,gromov@100,pfpf@100";

/// Reads "KIND[@PARTICLES][=CONFIG.yaml],...": a configuration of its own is read over `base`, and the
/// particles replace those of both. Every filter has one thread. Throws Error{usage} for an unknown kind, for
/// a wrong number and for the same label twice; Error{config} as read_config().
std::vector<Entry> read_entries(const std::string& list, const Config& base);

}  // namespace parloc::tools::compare
