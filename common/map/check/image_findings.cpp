#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "common/map/check/map_findings.h"

namespace parloc {
namespace {

// Greys nearer to black or white than these stand for a wall or for free space, however they were drawn.
constexpr std::size_t kDarkest = 26, kBrightest = 239;

const char* name_of(Cell cell) {
  return cell == Cell::free ? "free" : cell == Cell::occupied ? "occupied" : "unknown";
}

/// The pixels of an image by their grey.
class Greys {
 public:
  explicit Greys(const ImageMap& read) : read_(read) {}

  std::size_t count(std::size_t grey) const {
    const auto& of_grey = read_.cells_of_grey[grey];
    return std::accumulate(of_grey.begin(), of_grey.end(), std::size_t{0});
  }
  std::size_t count(std::size_t first, std::size_t last) const {
    std::size_t sum = 0;
    for (std::size_t grey = first; grey <= last; ++grey) sum += count(grey);
    return sum;
  }
  std::size_t all() const { return read_.map.size(); }
  double percent(std::size_t pixels) const {
    return 100.0 * static_cast<double>(pixels) / static_cast<double>(all());
  }
  /// How many greys in the range there are at all.
  std::size_t levels(std::size_t first, std::size_t last) const {
    std::size_t sum = 0;
    for (std::size_t grey = first; grey <= last; ++grey) sum += count(grey) > 0 ? 1 : 0;
    return sum;
  }
  /// What most pixels of the grey became.
  Cell cell(std::size_t grey) const {
    const auto& of_grey = read_.cells_of_grey[grey];
    return static_cast<Cell>(std::max_element(of_grey.begin(), of_grey.end()) - of_grey.begin());
  }
  /// The one grey between black and white that most of the greys between are, and at least a hundredth of the
  /// image: what its maker calls unknown. 0: none.
  std::size_t unknown_grey() const {
    std::size_t most = kDarkest;
    for (std::size_t grey = kDarkest; grey <= kBrightest; ++grey)
      if (count(grey) > count(most)) most = grey;
    const bool stands_out = 2 * count(most) >= count(kDarkest, kBrightest) && 100 * count(most) >= all();
    return stands_out ? most : 0;
  }
  double occupancy(std::size_t grey) const {
    const double shade = static_cast<double>(grey) / 255.0;
    return read_.yaml.negate ? shade : 1.0 - shade;
  }

 private:
  const ImageMap& read_;
};

/// Why the grey that was meant to be unknown is not.
std::string reason(const ImageMap& read, const Greys& greys, std::size_t grey) {
  const MapYaml& yaml = read.yaml;
  const bool is_free = greys.cell(grey) == Cell::free;
  const double occupancy = greys.occupancy(grey);
  if (read.has_alpha && yaml.mode == MapMode::trinary)
    return fmt::format(
        "in mode trinary alpha counts as a fourth colour, which makes it {}: save the image without alpha, "
        "or say mode: scale",
        (3.0 * static_cast<double>(grey) + 255.0) / 4.0);
  if (is_free && occupancy < yaml.free_thresh)
    return fmt::format("its occupancy {:.5f} is below free_thresh {}; {:.3f} would leave it unknown",
                       occupancy, yaml.free_thresh, std::floor(occupancy * 1000.0) / 1000.0);
  if (!is_free && occupancy > yaml.occupied_thresh)
    return fmt::format("its occupancy {:.5f} is above occupied_thresh {}{}", occupancy, yaml.occupied_thresh,
                       yaml.negate ? ", with negate" : "");
  return fmt::format("the mean of its colours is just {}", is_free ? "below free_thresh"
                                                                   : "above "
                                                                     "occupied_thresh");
}

void find_known_unknown(const ImageMap& read, const Greys& greys, std::vector<std::string>& findings) {
  const std::size_t grey = greys.unknown_grey();
  if (grey == 0 || greys.cell(grey) == Cell::unknown || read.yaml.mode == MapMode::raw) return;
  const bool none =
      std::find(read.map.cells.begin(), read.map.cells.end(), Cell::unknown) == read.map.cells.end();
  findings.push_back(fmt::format("{}grey {}, {:.1f} % of the image, is {}: {}",
                                 none ? "nothing is unknown: " : "too little is unknown: ", grey,
                                 greys.percent(greys.count(grey)), name_of(greys.cell(grey)),
                                 reason(read, greys, grey)));
}

/// What nav2 publishes of a grey between the thresholds in mode scale [%].
double scaled_occupancy(const MapYaml& yaml, double occupancy) {
  return std::rint(100.0 * (occupancy - yaml.free_thresh) / (yaml.occupied_thresh - yaml.free_thresh));
}

void find_wrong_mode(const ImageMap& read, const Greys& greys, std::vector<std::string>& findings) {
  const MapYaml& yaml = read.yaml;
  const std::size_t grey = greys.unknown_grey();
  const std::size_t other = greys.count(kDarkest, kBrightest) - (grey > 0 ? greys.count(grey) : 0);
  if (yaml.mode == MapMode::scale && grey > 0 && 200 * other < greys.all() && read.not_opaque == 0) {
    std::string as = fmt::format("grey {}, {:.1f} % of the image, is {}", grey,
                                 greys.percent(greys.count(grey)), name_of(greys.cell(grey)));
    if (greys.cell(grey) == Cell::unknown)
      as += fmt::format(" here and occupancy {:.0f} in nav2", scaled_occupancy(yaml, greys.occupancy(grey)));
    findings.push_back(
        "mode scale, but an image of black, white and one grey without transparency is trinary: " + as);
  }
  const std::size_t levels = greys.levels(kDarkest, kBrightest);
  if (yaml.mode == MapMode::trinary && levels >= 20 && 20 * other >= greys.all())
    findings.push_back(
        fmt::format("mode trinary, but {:.1f} % of the image are {} greys between black and white, as in one "
                    "for mode scale: those between the thresholds are unknown",
                    greys.percent(other), levels));
  if (yaml.mode == MapMode::raw && 2 * greys.count(101, 254) >= greys.all())
    findings.push_back(
        fmt::format("mode raw, but {:.1f} % of the image are 101 to 254, which is unknown: raw "
                    "values are 0 to 100",
                    greys.percent(greys.count(101, 254))));
  if (yaml.mode != MapMode::raw && !yaml.negate && greys.count(101, 254) == 0 && greys.count(100) > 0 &&
      greys.count(0) > greys.count(100))
    findings.push_back(
        fmt::format("mode {}, but all values are 0 to 100 or 255, as in one for mode raw: {:.1f} % "
                    "of the image are 0, which is black",
                    yaml.mode == MapMode::scale ? "scale" : "trinary", greys.percent(greys.count(0))));
}

void find_mostly_walls(const ImageMap& read, const Greys& greys, std::vector<std::string>& findings) {
  std::size_t occupied = 0, free = 0, bright = 0, dark = 0;
  for (std::size_t grey = 0; grey < 256; ++grey) {
    free += read.cells_of_grey[grey][0];
    occupied += read.cells_of_grey[grey][1];
    (grey < 128 ? dark : bright) += grey < kDarkest || grey > kBrightest ? greys.count(grey) : 0;
  }
  if (occupied <= free) return;
  const auto share = [](std::size_t part, std::size_t other) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(part + other);
  };
  std::string text =
      fmt::format("mostly walls: {:.1f} % of the known cells are occupied", share(occupied, free));
  const std::size_t walls = read.yaml.negate ? dark : bright, room = read.yaml.negate ? bright : dark;
  if (walls < room && read.yaml.mode != MapMode::raw)
    text +=
        fmt::format("; with negate: {} it would be {:.1f} %", read.yaml.negate ? 0 : 1, share(walls, room));
  findings.push_back(std::move(text));
}

void find_transparency(const ImageMap& read, const Greys& greys, std::vector<std::string>& findings) {
  if (read.yaml.mode == MapMode::raw || 2 * read.not_opaque < greys.all()) return;
  findings.push_back(fmt::format("{:.1f} % of the image are transparent: {}", greys.percent(read.not_opaque),
                                 read.yaml.mode == MapMode::scale
                                     ? "in mode scale they are unknown"
                                     : "in mode trinary alpha counts as a fourth colour"));
}

}  // namespace

std::vector<std::string> image_findings(const ImageMap& read) {
  const Greys greys(read);
  std::vector<std::string> findings;
  find_known_unknown(read, greys, findings);
  find_wrong_mode(read, greys, findings);
  find_mostly_walls(read, greys, findings);
  find_transparency(read, greys, findings);
  return findings;
}

}  // namespace parloc
