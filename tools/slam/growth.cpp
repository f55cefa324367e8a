#include "tools/slam/growth.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tools/report/map_view.h"

namespace parloc::tools::slam {
namespace {

/// Fewer and larger cells; a wall stays a wall.
GridMap shrunk(const GridMap& map, std::int32_t most_cells) {
  MapView view;
  view.T_map_grid = map.T_map_grid, view.cell_m = map.resolution_m;
  view.down = (std::max(map.width, map.height) + most_cells - 1) / most_cells;
  if (view.down <= 1) return map;
  const auto down = static_cast<std::int32_t>(view.down);
  view.width_px = (map.width + down - 1) / down, view.height_px = (map.height + down - 1) / down;
  const std::vector<Cell> picture = raster(map, view);
  GridMap small;
  small.T_map_grid = map.T_map_grid, small.name = map.name;
  small.width = view.width_px, small.height = view.height_px;
  small.resolution_m = map.resolution_m * down;
  for (std::int32_t j = small.height - 1; j >= 0; --j) {  // a picture's first row is the top one
    const auto row = picture.begin() + std::ptrdiff_t{j} * small.width;
    small.cells.insert(small.cells.end(), row, row + small.width);
  }
  return small;
}

std::vector<Particle> drawn_of(const std::vector<Pose>& poses) {
  std::vector<Particle> particles;
  const std::size_t stride = (poses.size() + Snapshot::max_particles - 1) / Snapshot::max_particles;
  for (std::size_t k = 0; k < poses.size(); k += stride)
    particles.push_back({static_cast<float>(poses[k].x_m), static_cast<float>(poses[k].y_m),
                         static_cast<float>(poses[k].theta_rad), 1.0F});
  return particles;
}

Trajectory thinned(const Trajectory& path, std::size_t most) {
  if (path.size() <= most) return path;
  Trajectory out;
  for (std::size_t k = 0; k < most; ++k) out.push_back(path[k * (path.size() - 1) / (most - 1)]);
  return out;
}

std::string mebibytes(std::size_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1024.0 * 1024.0));
}

}  // namespace

std::size_t resampled(const std::vector<SlamRecord>& records) {
  return static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(), [](const SlamRecord& r) { return r.resampled; }));
}

double length_m(const Trajectory& path) {
  double sum_m = 0.0;
  for (std::size_t k = 1; k < path.size(); ++k) sum_m += distance_m(path[k - 1].pose, path[k].pose);
  return sum_m;
}

std::array<std::size_t, 4> quarters(const std::vector<std::size_t>& by_scan) {
  std::array<std::size_t, 4> out{};
  for (std::size_t q = 0; q < out.size() && !by_scan.empty(); ++q) out[q] = by_scan[q * by_scan.size() / 4];
  return out;
}

Growth growth_of(const GridSlam& slam, std::size_t scans) {
  const std::vector<SlamRecord>& records = slam.records();
  const Trajectory path = slam.trajectory_so_far();
  Growth g;
  g.state.stamp_s = path.back().stamp_s;
  g.state.pose = path.back().pose;
  g.state.particles = drawn_of(slam.poses());
  g.map = shrunk(slam.map_so_far(), Growth::most_cells);
  g.path = thinned(path, Growth::most_poses);
  g.distance_m = length_m(path);
  g.scans = scans, g.taken_in = records.size(), g.resampled = resampled(records);
  g.particles = static_cast<std::size_t>(slam.config().slam.particles);
  g.n_eff = records.back().n_eff;
  g.distinct = quarters(slam.distinct_ancestors());
  g.memory = slam.memory();
  return g;
}

MapMoment moment_of(const Growth& g) {
  return {g.state,
          g.map,
          g.path,
          {{"scans taken in", fmt::format("{} of {}", g.taken_in, g.scans)},
           {"distance", fmt::format("{:.1f} m", g.distance_m)},
           {"N_eff", fmt::format("{:.1f} of {}", g.n_eff, g.particles)},
           {"resampled", fmt::format("{} times", g.resampled)},
           {"distinct ancestors", fmt::format("{}", fmt::join(g.distinct, ", "))},
           {"memory", mebibytes(g.memory.tile_bytes)}}};
}

void write_live(const std::string& path, const Growth& g) {
  RunReport report;
  report.map = &g.map;
  report.estimate = g.path;
  report.snapshots = {g.state};
  write_live_picture(path, report,
                     fmt::format("{} scans, {:.0f} m, n eff {:.1f}, {}", g.scans, g.distance_m, g.n_eff,
                                 mebibytes(g.memory.tile_bytes)));
}

}  // namespace parloc::tools::slam
