// Settings of the closed loop: the filter's, the search's, and those of what watches them.
#pragma once

#include "common/filter/filter_config.h"
#include "common/search/search_config.h"

namespace parloc {

/// Settings of what watches the filter.
struct LocalizeConfig {
  bool health = true;  ///< Judge every estimate. Without it there is no search either.
  bool slips = true;   ///< Look around the prediction when the scan does not fit it: wheels slip.
  /// Search the map when lost, and for rivals while it is not sure. Else it only says so.
  bool recover = true;
  double carried_per_hour = 1.0;  ///< How often somebody carries the robot away: what it takes to believe it.
  /// The first search of start_anywhere() is done within one step, however long that takes. False: in slices
  /// as every other, so that each scan is answered in time; the robot is `lost` until it is done.
  bool first_search_at_once = true;
  double search_slice = 5.0;  ///< Most work of a search beside one scan [million; each 2 to 3 ms on a core].
  double search_every_m = 0.3;    ///< So far the robot goes between two searches for rivals,
  double search_every_rad = 0.3;  ///< or turns.
};

/// Everything that a Localizer reads.
struct LocalizerConfig : FilterConfig {
  LocalizeConfig localize;  ///< Of what watches the filter.
  SearchConfig search;      ///< Of the search of the whole map.
};

}  // namespace parloc
