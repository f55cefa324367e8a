// The places that drives of a family go through: the maps that come with parloc, and a corridor made to
// measure.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "common/map/grid_map.h"
#include "common/simulator/wander.h"

namespace parloc {

/// What is known of a place before its map is read.
struct PlaceFacts {
  std::string_view name;  ///< Of its map, `<name>.yaml`.
  bool fine = false;      ///< There is a finer map for the truth, fine/<name>.yaml.
  bool cells = true;      ///< Its walls are cells, not segments: it can be changed.
  double side_m =
      0.0;  ///< Of a square as large as where a robot can go, rounded: what its speed is limited by.
  double block_from_m = 0.0, block_to_m = 0.0;  ///< Of both coordinates: where nobody gets in.
};
/// hall, hall_obstacles, office, works, malaga_corridor, malaga_faculty, ice_world, square_ring.
inline constexpr std::array<PlaceFacts, 8> kPlaces{{{"hall", true, true, 13.0},
                                                    {"hall_obstacles", true, true, 12.0},
                                                    {"office", true, true, 26.0},
                                                    {"works", true, true, 70.0},
                                                    {"malaga_corridor", false, true, 7.0},
                                                    {"malaga_faculty", false, true, 28.0},
                                                    {"ice_world", false, false, 39.0},
                                                    {"square_ring", false, false, 26.0, 5.0, 40.0}}};

struct Place {
  std::shared_ptr<const GridMap> map;  ///< What a localizer gets.
  std::shared_ptr<const GridMap>
      world;  ///< What rays are cast against; the same as the map where there is no finer one.
  std::shared_ptr<const WanderArea> area;  ///< Where a robot can go on the map; none of a corridor.
};

/// Reads each map when it is first asked for. May be asked from several threads.
class Places {
 public:
  /// `folder` has the maps. Throws Error{input} if it has none of that of the first place.
  explicit Places(std::string folder);
  /// Throws Error{input} as read_map().
  const Place& at(std::size_t index) const;

 private:
  std::string folder_;
  mutable std::array<std::once_flag, kPlaces.size()> read_;
  mutable std::array<Place, kPlaces.size()> places_;
};

/// A straight corridor from (0, 0) to (length, width), closed at both ends, off the grid of its map.
Place corridor_place(double length_m, double width_m);

}  // namespace parloc
