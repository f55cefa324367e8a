// The YAML half of a ROS map_server map: where the image is and what its pixels mean. docs/maps.md.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace parloc {

/// A map YAML has a dozen lines: a longer file than this is another kind of file.
inline constexpr std::size_t kLongestMapYaml = 64 * 1024;

/// How a pixel becomes a cell, as in nav2 map_server.
enum class MapMode {
  trinary,  ///< Occupancy is the darkness of the pixel, an alpha channel averaged in; two thresholds.
  scale,    ///< The same, but alpha is no brightness: any pixel that is not fully opaque is unknown.
  raw,      ///< The pixel value is the occupancy in percent; 101 to 255 is unknown; negate has no effect.
};

/// What a map's YAML file says.
struct MapYaml {
  std::string image;           ///< As written: relative to the YAML file's folder, or absolute.
  std::size_t image_line = 0;  ///< Line of the key `image`, for messages.
  double resolution_m = 0.0;   ///< Side of a cell.
  Pose T_map_grid;      ///< `origin`: the lower-left corner of the image in the map frame; yaw in [-pi, pi).
  bool negate = false;  ///< Bright pixels are occupied, in place of dark ones.
  double occupied_thresh = 0.0;     ///< Occupancy above it is a wall, 0 to 1.
  double free_thresh = 0.0;         ///< Occupancy below it is free, 0 to 1.
  MapMode mode = MapMode::trinary;  ///< How a pixel becomes an occupancy.
  std::vector<std::string> notes;  ///< What is not used, or not as it stands: "m.yaml:7: ...", one line each.
};

/// Reads the text of a map's YAML file; `name` is used in messages only. Throws Error{input} with name:line
/// for text that is not a YAML mapping, a duplicate or missing key, a value of the wrong type or out of its
/// range, thresholds out of order, an unknown mode, and a key that is nearly a known one and stands for it.
/// Any other key is noted and not used, as in nav2. All keys are required except `mode` (trinary): a map
/// without thresholds means different things to different servers. Source of the rules: map_io.cpp of
/// nav2_map_server and the conversions of yaml-cpp.
MapYaml map_yaml_from_text(const std::string& text, const std::string& name);

}  // namespace parloc
