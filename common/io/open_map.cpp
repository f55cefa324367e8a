#include "common/io/open_map.h"

#include "common/bag/open_bag.h"
#include "common/io/bag_map.h"
#include "common/map/map_reader.h"

namespace parloc {

GridMap open_map(const std::string& path, const LogChoice& choice) {
  return is_bag(path) ? read_bag_map(path, choice) : read_map(path);
}

}  // namespace parloc
