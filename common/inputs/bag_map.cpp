#include "common/inputs/bag_map.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/inputs/topic_choice.h"
#include "common/map/map_limits.h"

namespace parloc {

namespace {

constexpr int kLeastOccupied = 65, kMostFree = 25;  // percent: map_saver's thresholds
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

GridMap read_bag_map(const std::string& path, const LogChoice& choice) {
  const auto bag = open_bag(path);
  const std::size_t topic = choose_topic(
      *bag, path,
      {choice.map_topic, "--map-topic", "a map", {"nav_msgs/OccupancyGrid"}, "--map M.yaml gives one"});
  std::vector<bool> wanted(bag->topics().size(), false);
  wanted[topic] = true;
  bag->select(wanted);
  std::optional<GridMap> map;
  std::string trouble;
  std::size_t count = 0;
  for (BagMessage message; bag->next(message);) {
    try {
      const MessageReader in(message.bytes, bag->topics()[topic].encoding);
      map = map_from_message(read_occupancy_grid(in), path);
      ++count;
    } catch (const BrokenMessage& broken) {
      trouble = broken.why;
    }
  }
  const std::string name = printable(bag->topics()[topic].name);
  if (!map) throw input_error(path, 0, fmt::format("{}: {}", name, trouble.empty() ? "no message" : trouble));
  if (count > 1) map->notes.push_back(fmt::format("{}: {}: the last of {} maps is used", path, name, count));
  if (!trouble.empty()) map->notes.push_back(fmt::format("{}: {}: {}", path, name, trouble));
  return *std::move(map);
}

}  // namespace parloc
