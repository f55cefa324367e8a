// The table of settings of the filters on the distance field.
#pragma once

#include "common/flow/flow_config.h"
#include "common/settings/setting.h"

namespace parloc {

/// The group "flow"; `max_beams` is that of these filters. What is given outlives the table.
void add_flow_settings(Settings& s, FlowConfig& flow, int& max_beams);

}  // namespace parloc
