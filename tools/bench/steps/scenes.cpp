#include "tools/bench/steps/scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <system_error>

#include "common/error.h"
#include "common/filter/start.h"
#include "common/map/map_reader.h"
#include "common/math/angle_units.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/simulator/simulator.h"
#include "tools/report/machine/machine.h"

namespace parloc::tools::bench {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kRangeSigma_m = 0.02;

/// 40 x 30 m without a wall. From the central 20 x 10 m the edges are at least 10 m away.
Scene no_hit() {
  Scene scene;
  scene.name = "no_hit";
  scene.what =
      "800 x 600 empty cells of 5 cm, poses in the central 20 x 10 m: no ray hits, the paper's worst case";
  scene.map.width = 800;
  scene.map.height = 600;
  scene.map.resolution_m = 0.05;
  scene.map.name = "no_hit";
  scene.map.cells.assign(std::size_t{800} * 600, Cell::free);
  scene.start_area = scene.map;
  for (int j = 0; j < 600; ++j) {
    for (int i = 0; i < 800; ++i) {
      const bool central = i >= 200 && i < 600 && j >= 200 && j < 400;
      if (!central) scene.start_area.cells[static_cast<std::size_t>(j * 800 + i)] = Cell::unknown;
    }
  }
  scene.pose = {20.0, 15.0, 0.0};
  return scene;
}

Scene from_map(const std::string& name, const std::string& what, const std::string& folder,
               const Pose& pose) {
  Scene scene;
  scene.name = name;
  scene.map = read_map(folder + "/" + name + ".yaml");
  scene.what = fmt::format("{}: {} x {} cells of {:g} cm", what, scene.map.width, scene.map.height,
                           100.0 * scene.map.resolution_m);
  if (!scene.map.walls.empty()) scene.what = fmt::format("{}: {} walls", what, scene.map.walls.size());
  scene.start_area = scene.map;
  scene.pose = pose;
  if (scene.map.at_point(pose.x_m, pose.y_m) != Cell::free) {
    throw Error(ErrorKind::input,
                fmt::format("{}: expected the map that comes with parloc, in which ({}, {}) is free",
                            scene.map.name, pose.x_m, pose.y_m));
  }
  return scene;
}

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// Beside the program, as installed; empty if the program's own path cannot be found out.
fs::path installed_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : (program.parent_path() / kMapsFromProgram).lexically_normal();
}

}  // namespace

Scene make_scene(const std::string& name, const std::string& maps_folder) {
  // In the halls the middle of the way of maps/paths/hall_17m.yaml, in the office a corridor of its tour.
  if (name == "no_hit") return no_hit();
  if (name == "hall") return from_map(name, "a hall with nothing in it", maps_folder, {9.65, 4.42, 0.0});
  if (name == "hall_obstacles")
    return from_map(name, "the hall with walls, pillars and boxes", maps_folder, {9.65, 4.42, 0.0});
  if (name == "hall_segments")
    return from_map(name, "the same hall, its walls as segments", maps_folder, {9.65, 4.42, 0.0});
  if (name == "office") return from_map(name, "an office floor", maps_folder, {9.65, 12.0, 1.5});
  throw Error(
      ErrorKind::usage,
      fmt::format("--scene: expected no_hit, hall, hall_obstacles, hall_segments or office, got '{}'", name));
}

Scan make_scan(const Scene& scene, int beams) {
  Scan scan;
  scan.angle_min_rad = -0.5 * kFieldOfView_deg * kRadPerDeg;
  scan.angle_step_rad = kFieldOfView_deg * kRadPerDeg / (beams - 1);
  scan.range_min_m = 0.05;
  scan.range_max_m = kRangeMax_m;
  for (int k = 0; k < beams; ++k) {
    const double angle_rad = scene.pose.theta_rad + scan.angle_min_rad + k * scan.angle_step_rad;
    const SimulatedHit hit =
        cast_simulated_ray(scene.map, scene.pose.x_m, scene.pose.y_m, angle_rad, kRangeMax_m);
    const Normals noise =
        normals(philox(static_cast<std::uint32_t>(k), 0, Stream::simulated_beams, 0, kSeed));
    const double range_m = hit.hit ? hit.range_m + kRangeSigma_m * noise.n[0] : kRangeMax_m;
    scan.ranges_m.push_back(static_cast<float>(range_m));
  }
  return scan;
}

ParticleSet make_cloud(const Scene& scene, Cloud cloud, std::int64_t particles) {
  return cloud == Cloud::tracking ? gaussian_start(scene.map, scene.pose, 0.2, 0.2, 0.1, particles, kSeed)
                                  : uniform_start(scene.start_area, particles, kSeed);
}

std::string find_maps_folder(const std::string& given) {
  if (!given.empty()) {
    if (!is_folder(given)) throw Error(ErrorKind::input, given + ": expected a folder of maps (--maps)");
    return given;
  }
  const fs::path installed = installed_folder();
  for (const fs::path& path : {installed, fs::path(kMapsOfSource)}) {
    if (!path.empty() && is_folder(path)) return path.string();
  }
  throw Error(ErrorKind::input,
              fmt::format("the maps that come with parloc are neither in {} nor in {}: give --maps DIR",
                          installed.string(), kMapsOfSource));
}

}  // namespace parloc::tools::bench
