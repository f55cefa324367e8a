// Settings of what watches the filter.
#pragma once

namespace parloc {

/// What surrounds the filter (common/localize/localizer.h); the filter itself knows nothing of it.
struct LocalizeConfig {
  bool health = true;  ///< Judge every estimate. Without it there is no search either.
  bool recover =
      true;  ///< Search the map when lost, and for rivals while it is not sure. Else it only says so.
};

}  // namespace parloc
