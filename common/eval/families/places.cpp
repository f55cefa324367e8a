#include "common/eval/families/places.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/error.h"
#include "common/map/map_reader.h"

namespace parloc {
namespace {

constexpr double kClearance_m = 0.3;  // of the drives from walls
constexpr double kWall_m = 0.2, kMargin_m = 0.5;

/// The corridor in cells of this size; those whose centre is inside are free, and there are walls around.
GridMap corridor_map(double length_m, double width_m, double resolution_m) {
  GridMap map;
  map.name = fmt::format("a corridor of {:g} x {:g} m", length_m, width_m);
  map.resolution_m = resolution_m;
  map.width = static_cast<std::int32_t>(std::ceil((length_m + 2.0 * kMargin_m) / resolution_m));
  map.height = static_cast<std::int32_t>(std::ceil((width_m + 2.0 * kMargin_m) / resolution_m));
  map.T_map_grid = {-kMargin_m, -kMargin_m, 0.0};
  map.cells.resize(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  const auto outside_m = [](double at_m, double size_m) { return std::fmax(-at_m, at_m - size_m); };
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i) {
      const double off_m = std::fmax(outside_m((i + 0.5) * resolution_m - kMargin_m, length_m),
                                     outside_m((j + 0.5) * resolution_m - kMargin_m, width_m));
      map.cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) +
                static_cast<std::size_t>(i)] = off_m < 0.0        ? Cell::free
                                               : off_m <= kWall_m ? Cell::occupied
                                                                  : Cell::unknown;
    }
  return map;
}

/// The map for driving: who is in the block in the middle of a ring could only be there.
GridMap around_block(const GridMap& map, double from_m, double to_m) {
  GridMap ring = map;
  const auto inside = [&](double at_m) { return at_m > from_m && at_m < to_m; };
  for (std::int32_t j = 0; j < map.height; ++j)
    for (std::int32_t i = 0; i < map.width; ++i) {
      const Pose p =
          compose(map.T_map_grid, {(i + 0.5) * map.resolution_m, (j + 0.5) * map.resolution_m, 0.0});
      if (inside(p.x_m) && inside(p.y_m))
        ring.cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) +
                   static_cast<std::size_t>(i)] = Cell::unknown;
    }
  return ring;
}

}  // namespace

Places::Places(std::string folder) : folder_(std::move(folder)) {
  const std::string first = fmt::format("{}/{}.yaml", folder_, kPlaces[0].name);
  std::error_code none;
  if (!std::filesystem::exists(first, none))
    throw Error(
        ErrorKind::input,
        fmt::format("{}: expected the maps that come with parloc (--maps DIR), found no {}", folder_, first));
}

const Place& Places::at(std::size_t index) const {
  std::call_once(read_.at(index), [&] {
    const PlaceFacts& facts = kPlaces.at(index);
    Place& place = places_[index];
    place.map = std::make_shared<const GridMap>(read_map(fmt::format("{}/{}.yaml", folder_, facts.name)));
    place.world =
        facts.fine
            ? std::make_shared<const GridMap>(read_map(fmt::format("{}/fine/{}.yaml", folder_, facts.name)))
            : place.map;
    place.area = std::make_shared<const WanderArea>(
        facts.block_to_m > 0.0 ? around_block(*place.map, facts.block_from_m, facts.block_to_m) : *place.map,
        kClearance_m);
  });
  return places_[index];
}

Place corridor_place(double length_m, double width_m) {
  Place place;
  place.map = std::make_shared<const GridMap>(corridor_map(length_m, width_m, 0.05));
  place.world = std::make_shared<const GridMap>(corridor_map(length_m, width_m, 0.01));
  return place;
}

}  // namespace parloc
