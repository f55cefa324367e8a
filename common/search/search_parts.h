// What a global search is made of, for tests and benchmarks: no part of what is installed.
#pragma once

#include <cstddef>
#include <vector>

#include "common/search/global_search.h"
#include "common/search/hypotheses.h"
#include "common/search/search_map.h"
#include "common/search/search_scan.h"

namespace parloc {

/// Of a search that outlives this.
class SearchParts {
 public:
  explicit SearchParts(GlobalSearch& search) : search_(search) {}

  /// The exhaustive part alone: at most `most` separated poses of the lattice, best first.
  std::vector<LatticePose> search_lattice(const BeamTable& beams, const SearchPrior& prior, std::size_t most);
  const SearchMap& map() const;
  const SearchScan& scan() const;  ///< Of the last search; offsets of the headings it was about.

 private:
  GlobalSearch& search_;
};

}  // namespace parloc
