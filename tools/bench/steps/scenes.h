// Where the benchmark happens: map, LiDAR and particles, the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/filter/filter_backend.h"
#include "common/io/log.h"
#include "common/map/grid_map.h"

namespace parloc::tools::bench {

struct Scene {
  std::string name;
  std::string what;  ///< For people, a few words.
  GridMap map;
  GridMap start_area;  ///< The map with only those cells free where a global cloud may be.
  Pose pose;           ///< Of the robot, in the map frame: where the scan is taken.
};

/// The scenes' names, in the order of the documentation.
inline constexpr std::array<const char*, 5> kSceneNames{"no_hit", "hall", "hall_obstacles", "hall_segments",
                                                        "office"};

inline constexpr double kRangeMax_m = 8.0;
inline constexpr double kFieldOfView_deg = 270.0;

enum class Cloud { tracking, global };
inline constexpr std::array<const char*, 2> kCloudNames{"tracking", "global"};

/// no_hit is generated, the others are read from `maps_folder`. Throws Error{usage} for another name,
/// Error{input} for a map that cannot be read or in which the robot's pose is not free.
Scene make_scene(const std::string& name, const std::string& maps_folder);

/// What the LiDAR sees from the scene's pose: `beams` (2 or more) evenly over the field of view, both ends
/// included, with Gaussian noise of 2 cm from a fixed seed.
Scan make_scan(const Scene& scene, int beams);

/// tracking: Gaussian about the scene's pose, 0.2 m and 0.1 rad. global: uniform over the start area.
ParticleSet make_cloud(const Scene& scene, Cloud cloud, std::int64_t particles);

/// `given`, if not empty; else the maps of the installation that this program is part of; else those of the
/// source tree it was built from. Throws Error{input} that says where it looked if there is no such folder.
std::string find_maps_folder(const std::string& given);

}  // namespace parloc::tools::bench
