#include "common/inputs/bag_map.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/inputs/map_message.h"
#include "common/inputs/topic_choice.h"

namespace parloc {

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
