// Opens a map, whatever holds it.
#pragma once

#include <string>

#include "common/io/log_choice.h"
#include "common/map/grid_map.h"

namespace parloc {

/// A map file as read_map() has them, or a bag with a map in it, told by content. Throws Error{input} as
/// their readers.
GridMap open_map(const std::string& path, const LogChoice& choice);

}  // namespace parloc
