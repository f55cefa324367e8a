#include "common/map/map_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "common/error.h"
#include "common/file/input_file.h"
#include "common/file/output_file.h"
#include "common/map/map_limits.h"
#include "common/map/map_yaml.h"
#include "common/map/segment_map.h"

namespace parloc {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

GreyImage image_from_bytes(const std::string& bytes, const std::string& name) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const auto starts_with = [&](std::string_view magic) { return bytes.compare(0, magic.size(), magic) == 0; };
  if (starts_with(kPngSignature)) return read_png(data, bytes.size(), name);
  if (starts_with("P2") || starts_with("P5")) return read_pgm(data, bytes.size(), name);
  throw input_error(name, 0, "expected a PGM (P2 or P5) or a PNG image");
}

/// Occupancy in [0, 1] -> cell, by the thresholds (SPEC 0.2).
Cell cell_of_occupancy(double p, const MapYaml& yaml) {
  if (p > yaml.occupied_thresh) return Cell::occupied;
  return p < yaml.free_thresh ? Cell::free : Cell::unknown;
}

/// Brightness in [0, 255] -> cell.
Cell cell_of_brightness(double v, const MapYaml& yaml) {
  return cell_of_occupancy((yaml.negate ? v : 255.0 - v) / 255.0, yaml);
}

Cell cell_of_opaque_pixel(std::uint8_t grey, const MapYaml& yaml) {
  if (yaml.mode != MapMode::raw) return cell_of_brightness(grey, yaml);
  return grey > 100 ? Cell::unknown : cell_of_occupancy(grey / 100.0, yaml);
}

/// A pixel of an image that has an alpha channel: trinary counts alpha as a fourth colour, scale asks it to
/// be opaque, raw ignores it (as nav2_map_server does).
Cell cell_of_pixel(std::uint8_t grey, std::uint8_t alpha, const MapYaml& yaml) {
  if (yaml.mode == MapMode::trinary) return cell_of_brightness((3.0 * grey + alpha) / 4.0, yaml);
  if (yaml.mode == MapMode::scale && alpha != 255) return Cell::unknown;
  return cell_of_opaque_pixel(grey, yaml);
}

GridMap grid_of_image(const GreyImage& image, const MapYaml& yaml, const std::string& name) {
  std::array<Cell, 256> opaque;
  for (std::size_t v = 0; v < opaque.size(); ++v)
    opaque[v] = cell_of_opaque_pixel(static_cast<std::uint8_t>(v), yaml);
  GridMap map;
  map.width = image.width;
  map.height = image.height;
  map.resolution_m = yaml.resolution_m;
  map.T_map_grid = yaml.T_map_grid;
  map.name = name;
  map.cells.resize(image.pixels.size());
  const std::size_t width = static_cast<std::size_t>(image.width);
  const std::size_t height = static_cast<std::size_t>(image.height);
  for (std::size_t row = 0; row < height; ++row) {
    Cell* cells = map.cells.data() + (height - 1 - row) * width;  // row 0 is the top
    const std::size_t first = row * width;
    for (std::size_t i = 0; i < width; ++i) {
      const std::size_t k = first + i;
      cells[i] = image.alpha.empty() ? opaque[image.pixels[k]]
                                     : cell_of_pixel(image.pixels[k], image.alpha[k], yaml);
    }
  }
  return map;
}

GridMap image_map(const std::string& text, const std::string& yaml_path) {
  const MapYaml yaml = map_yaml_from_text(text, yaml_path);
  const std::string image_path = (fs::path(yaml_path).parent_path() / yaml.image).string();
  const std::string bytes =
      read_input_file(image_path, fmt::format("{}:{}: image {}", yaml_path, yaml.image_line, image_path));
  return grid_of_image(image_from_bytes(bytes, image_path), yaml, yaml_path);
}

std::string pgm_of_map(const GridMap& map) {
  std::string bytes = fmt::format("P5\n{} {}\n255\n", map.width, map.height);
  bytes.reserve(bytes.size() + map.size());
  for (std::int32_t j = map.height - 1; j >= 0; --j) {
    for (std::int32_t i = 0; i < map.width; ++i) {
      const Cell cell = map.at(i, j);
      bytes += static_cast<char>(cell == Cell::free       ? 254
                                 : cell == Cell::occupied ? 0
                                                          : 205);  // map_server's values
    }
  }
  return bytes;
}

/// A YAML scalar in double quotes, so that any file name is safe in it.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
  }
  return out + '"';
}

std::string yaml_of_map(const GridMap& map, const std::string& image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      quoted(image), map.resolution_m, map.T_map_grid.x_m, map.T_map_grid.y_m, map.T_map_grid.theta_rad);
}

void check_writable(const std::string& yaml_path, const fs::path& image_path, const GridMap& map) {
  const auto fail = [&](const std::string& message) {
    throw Error(ErrorKind::output, yaml_path + ": " + message);
  };
  if (!fs::path(yaml_path).has_filename()) fail("expected a file name such as map.yaml");
  if (image_path == fs::path(yaml_path)) fail("is the name of the image: expected one such as map.yaml");
  const bool sides =
      map.width >= 1 && map.height >= 1 && map.width <= kMaxMapSide && map.height <= kMaxMapSide;
  if (!sides || map.size() != static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height)) {
    fail(fmt::format("a map of {} x {} with {} cells cannot be written: expected sides from 1 to {}",
                     map.width, map.height, map.size(), kMaxMapSide));
  }
}

}  // namespace

GridMap read_map(const std::string& path) {
  const std::string text = read_input_file(path, path, kLongestSegmentFile + 1);
  if (!is_segment_text(text, path)) return image_map(text, path);
  return place_segments(segment_map_from_text(text, path), path).map;
}

void write_map(const std::string& yaml_path, const GridMap& map) {
  const fs::path image_path = fs::path(yaml_path).replace_extension(".pgm");
  check_writable(yaml_path, image_path, map);
  expect_writable(yaml_path);
  replace_file(image_path.string(), pgm_of_map(map));  // first, so that a new YAML never lacks its image
  replace_file(yaml_path, yaml_of_map(map, image_path.filename().string()));
}

}  // namespace parloc
