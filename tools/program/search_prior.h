// What the command line says of where the robot may be: --near and --heading.
#pragma once

#include <string>

#include "common/search/search_config.h"

namespace parloc::tools {

/// `near` is "x,y,radius" [m], `heading` "angle,tolerance" [rad]; empty is not known. Throws Error{usage} for
/// anything else.
SearchPrior parse_search_prior(const std::string& near, const std::string& heading);

}  // namespace parloc::tools
