// The keys of a segment map in YAML.
#pragma once

#include <array>
#include <string_view>

namespace parloc {

inline constexpr std::array<std::string_view, 5> kSegmentKeys = {"name", "resolution", "segments",
                                                                 "polylines", "polygons"};

}  // namespace parloc
