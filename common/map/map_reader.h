// Reads maps: ROS map_server maps (a YAML file beside a PGM or PNG image) and segment maps (YAML or GeoJSON).
// Writes the former.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/map/grid_map.h"

namespace parloc {

/// An 8-bit grey image, row 0 at the top. alpha is empty or one value per pixel.
struct GreyImage {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<std::uint8_t> pixels;
  std::vector<std::uint8_t> alpha;
};

/// Throws Error{input} naming file (and line, where there is one) and what was expected: an unknown key, a
/// missing image, a resolution that is not positive, thresholds out of order, an unknown mode, a truncated
/// image. mode trinary (default), scale and raw as in nav2 map_server; `negate` and origin yaw are honoured.
/// A segment map (common/map/segment_map.h), told by its content or by the endings .geojson and .json, has
/// walls too.
GridMap read_map(const std::string& path);

/// Reads P2 and P5 PGM with any maxval up to 65535, or PNG of any depth and colour type.
GreyImage read_pgm(const std::uint8_t* data, std::size_t size, const std::string& name);
GreyImage read_png(const std::uint8_t* data, std::size_t size, const std::string& name);

/// Writes `path` (YAML) and the PGM of the same stem beside it, trinary. Throws Error{output}.
void write_map(const std::string& yaml_path, const GridMap& map);

}  // namespace parloc
