// Reads maps: ROS map_server maps (a YAML file beside a PGM, PNG or BMP image) and segment maps (YAML or
// GeoJSON). Writes the former.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "common/map/map_yaml.h"

namespace parloc {

/// A grey image, row 0 at the top.
struct GreyImage {
  std::int32_t width = 0;            ///< Pixels along a row.
  std::int32_t height = 0;           ///< Rows.
  std::vector<std::uint8_t> pixels;  ///< Rounded to 8 bits.
  std::vector<std::uint8_t> alpha;   ///< Empty, or one value per pixel.
  /// Where the file says more than 8 bits of grey: red + green + blue of each pixel, each 0 to 65535 (8-bit
  /// values times 257). Empty: all three are pixels[k] * 257.
  std::vector<std::uint32_t> colour_sums;
  std::vector<std::uint16_t> alpha_16;  ///< Of an image with 16-bit alpha, 0 to 65535; else empty.
};

/// Throws Error{input} naming file (and line, where there is one) and what was expected: a key that is nearly
/// a known one, a missing image, a resolution that is not positive, thresholds out of order, an unknown mode,
/// a truncated image. mode trinary (default), scale and raw as in nav2 map_server; `negate` and origin yaw
/// are honoured. A segment map (common/map/segment_map.h), told by its content or by the endings .geojson and
/// .json, has walls too.
GridMap read_map(const std::string& path);

/// A grid map and what only its files know.
struct ImageMap {
  GridMap map;   ///< As read_map() gives it.
  MapYaml yaml;  ///< What the YAML file says.
  /// How many pixels of each grey, rounded to 8 bits, became free, occupied and unknown.
  std::array<std::array<std::size_t, 3>, 256> cells_of_grey{};
  bool has_alpha = false;      ///< The image has an alpha channel.
  std::size_t not_opaque = 0;  ///< Pixels.
};
/// `text` is that of the YAML file at `yaml_path`. Throws as read_map().
ImageMap read_image_map(const std::string& text, const std::string& yaml_path);

/// Reads P2 and P5 PGM with any maxval up to 65535, PNG of any depth and colour type, or BMP without
/// compression of 1, 4, 8, 24 or 32 bits per pixel. Memory stays in proportion to `size`, whatever the file
/// claims. Throws Error{input}.
GreyImage read_pgm(const std::uint8_t* data, std::size_t size, const std::string& name);
/// As read_pgm.
GreyImage read_png(const std::uint8_t* data, std::size_t size, const std::string& name);
/// As read_pgm.
GreyImage read_bmp(const std::uint8_t* data, std::size_t size, const std::string& name);

/// Writes `path` (YAML) and the PGM of the same stem beside it, trinary. Throws Error{output}, and
/// Error{input} for a map that is none (validate).
void write_map(const std::string& yaml_path, const GridMap& map);

}  // namespace parloc
