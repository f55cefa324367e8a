// Where the maps are that come with parloc.
#pragma once

#include <string>

namespace parloc::tools::bench {

/// `given`, if not empty; else the maps of the installation that this program is part of; else those of the
/// source tree it was built from. Throws Error{input} that says where it looked if there is no such folder.
std::string find_maps_folder(const std::string& given);

}  // namespace parloc::tools::bench
