#include "common/inputs/map_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/map/map_limits.h"
#include "common/ros/message_writer.h"

namespace parloc {

namespace {

constexpr int kLeastOccupied = 65, kMostFree = 25;  // percent
constexpr double kMostMapTilt_rad = 1e-3;

/// The message has 0.05 as a float32, 0.0500000007: what was meant is the shortest number of that value.
double as_meant(float resolution_m) {
  return std::stod(fmt::format("{}", resolution_m));
}

}  // namespace

GridMap map_from_message(const OccupancyGridMessage& message, const std::string& name) {
  constexpr auto most = static_cast<std::uint32_t>(kMaxMapSide);
  if (message.width < 1 || message.height < 1 || message.width > most || message.height > most)
    throw BrokenMessage{fmt::format("expected a map of 1 to {} cells a side, found {} x {}", most,
                                    message.width, message.height)};
  if (!(message.resolution_m >= kFinestResolution_m && message.resolution_m <= kCoarsestResolution_m))
    throw BrokenMessage{fmt::format("expected cells of {} to {} m, found {}", kFinestResolution_m,
                                    kCoarsestResolution_m, message.resolution_m)};
  const std::size_t size = std::size_t{message.width} * message.height;
  if (message.cells.size() != size)
    throw BrokenMessage{fmt::format("expected {} cells, found {}", size, message.cells.size())};
  RigidTransform origin = message.origin;
  if (!normalise(origin) || planar_mount(origin).tilt_rad > kMostMapTilt_rad)
    throw BrokenMessage{"expected a map that lies flat"};
  GridMap map;
  map.width = static_cast<std::int32_t>(message.width);
  map.height = static_cast<std::int32_t>(message.height);
  map.resolution_m = as_meant(message.resolution_m);
  map.T_map_grid = planar(origin);
  map.name = name;
  map.cells.reserve(size);
  for (const std::int8_t cell : message.cells)
    map.cells.push_back(cell < 0                 ? Cell::unknown
                        : cell >= kLeastOccupied ? Cell::occupied
                        : cell <= kMostFree      ? Cell::free
                                                 : Cell::unknown);
  return map;
}

OccupancyGridMessage message_of_map(const GridMap& map, const MessageHeader& header, std::size_t most_cells) {
  std::int32_t factor = 1;
  const auto fewer = [&](std::int32_t cells) { return (cells + factor - 1) / factor; };
  const auto size = [&] {
    return static_cast<std::size_t>(fewer(map.width)) * static_cast<std::size_t>(fewer(map.height));
  };
  while (size() > most_cells) ++factor;
  OccupancyGridMessage grid;
  grid.header = header;
  grid.resolution_m = map.resolution_m * factor;
  grid.width = static_cast<std::uint32_t>(fewer(map.width));
  grid.height = static_cast<std::uint32_t>(fewer(map.height));
  grid.origin = spatial(map.T_map_grid);
  grid.cells.assign(size(), std::int8_t{-1});
  for (std::int32_t j = 0; j < map.height; ++j) {
    for (std::int32_t i = 0; i < map.width; ++i) {
      const Cell cell = map.cells[map.index(i, j)];
      if (cell == Cell::unknown) continue;
      std::int8_t& coarse = grid.cells[static_cast<std::size_t>(j / factor) * grid.width +
                                       static_cast<std::size_t>(i / factor)];
      coarse = std::max(coarse, static_cast<std::int8_t>(cell == Cell::occupied ? 100 : 0));
    }
  }
  return grid;
}

}  // namespace parloc
