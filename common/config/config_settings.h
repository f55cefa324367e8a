// The table of all settings.
#pragma once

#include "common/config/config.h"
#include "common/settings/setting.h"

namespace parloc {

/// In printed order; `config` outlives it.
Settings settings_of(Config& config);

}  // namespace parloc
