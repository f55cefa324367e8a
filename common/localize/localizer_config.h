// Settings of the closed loop: the filter's, the search's, and those of what watches them.
#pragma once

#include "common/filter/filter_config.h"
#include "common/search/search_config.h"

namespace parloc {

struct LocalizeConfig {
  bool health = true;  ///< Judge every estimate. Without it there is no search either.
  bool slips = true;   ///< Look around the prediction when the scan does not fit it: wheels slip.
  /// Search the map when lost, and for rivals while it is not sure. Else it only says so.
  bool recover = true;
  double carried_per_hour = 1.0;  ///< How often somebody carries the robot away: what it takes to believe it.
  double search_every_m = 0.3, search_every_rad = 0.3;  ///< Of moving between two searches for rivals.
};

struct LocalizerConfig : FilterConfig {
  LocalizeConfig localize;
  SearchConfig search;
};

}  // namespace parloc
