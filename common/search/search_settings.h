// The table of settings of the global search.
#pragma once

#include "common/search/search_config.h"
#include "common/settings/setting.h"

namespace parloc {

/// The group "search"; the struct outlives the table.
void add_settings(Settings& s, SearchConfig& search);

}  // namespace parloc
