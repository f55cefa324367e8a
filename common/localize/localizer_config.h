// Settings of the closed loop: the filter's, the search's, and those of what watches them.
#pragma once

#include "common/filter/filter_config.h"
#include "common/search/search_config.h"

namespace parloc {

struct LocalizeConfig {
  bool health = true;  ///< Judge every estimate. Without it there is no search either.
  bool recover =
      true;  ///< Search the map when lost, and for rivals while it is not sure. Else it only says so.
  double search_after_s = 1.0;  ///< Lost for so long: fewer bad scans pass by themselves.
  double search_every_s = 0.5;  ///< Between two searches at least.
  double search_every_m = 0.3, search_every_rad = 0.3;  ///< And this much of moving, while it is not lost.
};

struct LocalizerConfig : FilterConfig {
  LocalizeConfig localize;
  SearchConfig search;
};

}  // namespace parloc
