// `parloc evaluate --relations`: a trajectory judged by relations, without a filter.
#pragma once

#include <string>

namespace parloc::tools {

/// The command line; what was not given is empty.
struct RelationsOptions {
  std::string trajectory, relations, dataset, out;
  bool json = false, quiet = false;
};

/// Gives the exit code; throws Error. `typed`: the whole command line, for the report.
int evaluate_relations(const RelationsOptions& o, const std::string& typed);

}  // namespace parloc::tools
