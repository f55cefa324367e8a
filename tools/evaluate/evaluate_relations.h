// `parloc evaluate --relations`: a trajectory is judged, without trials.
#pragma once

#include <string>

namespace parloc::tools {

/// Of a command line that asks for it; empty: not said.
struct RelationsOptions {
  std::string trajectory, relations, dataset, out;
  bool json = false, quiet = false;
};

/// Gives the exit code. Throws as published_log() and judge_by_relations() (relations.h), and Error{output}.
int evaluate_relations(const RelationsOptions& options, const std::string& typed);

}  // namespace parloc::tools
