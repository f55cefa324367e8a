// The table of settings of what watches the filter.
#pragma once

#include "common/localize/localizer_config.h"
#include "common/settings/setting.h"

namespace parloc {

/// The group "localize"; the struct outlives the table.
void add_settings(Settings& s, LocalizeConfig& localize);

}  // namespace parloc
