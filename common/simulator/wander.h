// Drives through a map that nobody planned: from a random place to random places, clear of walls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"

namespace parloc {

/// Where a robot can go on a map, as a lattice of about 0.2 m over the largest connected region. Built once
/// for many drives. Deterministic: equal maps and seeds give equal paths on every machine.
class WanderArea {
 public:
  /// Keeps `clearance_m` from all that is not free (Chebyshev distance). Throws Error{input} if the map has
  /// no region so wide in which a robot could go anywhere.
  WanderArea(const GridMap& map, double clearance_m);

  /// A path from a random place over random goals, 3 to 20 m apart, that takes at least `duration_s` at the
  /// speeds given.
  WaypointPath wander(double duration_s, double speed_mps, double turn_rate_rad_s, std::uint64_t seed) const;

  double area_m2() const;  ///< Of the region.

 private:
  using Node = std::int32_t;

  bool clear(std::int32_t i, std::int32_t j) const;
  bool clear_way(Node from, Node to) const;
  void keep_largest_region();
  std::vector<Node> neighbours(Node node) const;
  std::vector<Node> way_to_goal(Node from, std::uint32_t word) const;
  std::vector<Node> straightened(const std::vector<Node>& way) const;
  Waypoint point_of(Node node) const;

  std::int32_t width_ = 0, height_ = 0;  // of the map [cells]
  double resolution_m_ = 0.0;
  Pose T_map_grid_;
  std::int32_t stride_ = 1;              // cells between nodes
  std::int32_t columns_ = 0, rows_ = 0;  // of nodes
  std::vector<std::uint8_t> clear_;      // by cell
  std::vector<std::uint8_t> open_;       // by node
  std::vector<Node> places_;             // open nodes, in order
};

}  // namespace parloc
