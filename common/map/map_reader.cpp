#include "common/map/map_reader.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "common/error.h"
#include "common/file/input_file.h"
#include "common/file/output_file.h"
#include "common/map/map_limits.h"
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
  if (starts_with("BM")) return read_bmp(data, bytes.size(), name);
  throw input_error(name, 0, "expected a PGM (P2 or P5), a PNG or a BMP image");
}

/// Occupancy in [0, 1] -> cell. A tie with a threshold is unknown.
Cell cell_of_occupancy(double p, const MapYaml& yaml) {
  if (p > yaml.occupied_thresh) return Cell::occupied;
  return p < yaml.free_thresh ? Cell::free : Cell::unknown;
}

/// Brightness in [0, 1] -> cell of a pixel that is opaque or whose alpha counts already. "1 - shade" is
/// rounded as nav2 rounds it, which decides on ties: 204 of 255 is just below 0.2.
Cell cell_of_shade(double shade, const MapYaml& yaml) {
  if (yaml.mode != MapMode::raw) return cell_of_occupancy(yaml.negate ? shade : 1.0 - shade, yaml);
  const double percent = std::floor(shade * 255.0 + 0.5);
  return percent > 100.0 ? Cell::unknown : cell_of_occupancy(percent / 100.0, yaml);
}

constexpr double kWhite = 65535.0;  ///< Values have 16 bits while they are averaged.

/// What pixels become. An alpha channel is a fourth colour in trinary, must be opaque in scale, and is
/// ignored in raw (as nav2_map_server does).
class CellOfPixel {
 public:
  CellOfPixel(const GreyImage& image, const MapYaml& yaml) : image_(image), yaml_(yaml) {
    for (std::size_t v = 0; v < greys_.size(); ++v)
      greys_[v] = cell_of_shade(257.0 * static_cast<double>(v) / kWhite, yaml);
  }

  Cell operator()(std::size_t k) const {
    const bool has_alpha = !image_.alpha.empty();
    if (has_alpha && yaml_.mode == MapMode::scale && alpha(k) != kWhite) return Cell::unknown;
    if (has_alpha && yaml_.mode == MapMode::trinary)
      return cell_of_shade((colours(k) + alpha(k)) / 4.0 / kWhite, yaml_);
    if (image_.colour_sums.empty()) return greys_[image_.pixels[k]];
    return cell_of_shade(colours(k) / 3.0 / kWhite, yaml_);
  }

 private:
  double colours(std::size_t k) const {
    return image_.colour_sums.empty() ? 3.0 * 257.0 * image_.pixels[k] : image_.colour_sums[k];
  }
  double alpha(std::size_t k) const {
    return image_.alpha_16.empty() ? 257.0 * image_.alpha[k] : image_.alpha_16[k];
  }

  const GreyImage& image_;
  const MapYaml& yaml_;
  std::array<Cell, 256> greys_;
};

GridMap grid_of_image(const GreyImage& image, const MapYaml& yaml, const std::string& name) {
  const CellOfPixel cell_of_pixel(image, yaml);
  GridMap map;
  map.width = image.width;
  map.height = image.height;
  map.resolution_m = yaml.resolution_m;
  map.T_map_grid = yaml.T_map_grid;
  map.name = name;
  map.notes = yaml.notes;
  map.cells.resize(image.pixels.size());
  const std::size_t width = static_cast<std::size_t>(image.width);
  const std::size_t height = static_cast<std::size_t>(image.height);
  for (std::size_t row = 0; row < height; ++row) {
    Cell* cells = map.cells.data() + (height - 1 - row) * width;  // row 0 is the top
    for (std::size_t i = 0; i < width; ++i) cells[i] = cell_of_pixel(row * width + i);
  }
  return map;
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
  validate(map);
}

}  // namespace

ImageMap read_image_map(const std::string& text, const std::string& yaml_path) {
  ImageMap read;
  read.yaml = map_yaml_from_text(text, yaml_path);
  const std::string image_path = (fs::path(yaml_path).parent_path() / read.yaml.image).string();
  const std::string bytes = read_input_file(
      image_path, fmt::format("{}:{}: image {}", yaml_path, read.yaml.image_line, image_path));
  const GreyImage image = image_from_bytes(bytes, image_path);
  read.has_alpha = !image.alpha.empty();
  for (std::size_t k = 0; k < image.alpha.size(); ++k)
    if (image.alpha_16.empty() ? image.alpha[k] != 255 : image.alpha_16[k] != 65535) ++read.not_opaque;
  read.map = grid_of_image(image, read.yaml, yaml_path);
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    const std::size_t row = static_cast<std::size_t>(image.height) - 1 - k / width;
    ++read.cells_of_grey[image.pixels[k]][static_cast<std::size_t>(read.map.cells[row * width + k % width])];
  }
  return read;
}

GridMap read_map(const std::string& path) {
  const std::string text = read_input_file(path, path, kLongestSegmentFile + 1);
  if (!is_segment_text(text, path)) return read_image_map(text, path).map;
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
