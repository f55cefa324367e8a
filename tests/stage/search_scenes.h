// Rooms and what is seen in them, for the tests of the global search.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "common/math/portable64.h"
#include "common/model/beams.h"
#include "common/search/global_search.h"
#include "common/search/search_backend.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<SearchBackend> make_search_on_host(const SearchMap& map);
}
namespace test {

/// Two rooms that differ, with a passage; 7.05 x 4.6 m, so that no side is a whole number of blocks.
inline GridMap two_rooms(double yaw_rad = 0.0) {
  std::vector<std::string> rows(92, std::string(141, '.'));
  for (std::size_t i = 0; i < 141; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  for (std::size_t j = 0; j < 60; ++j) rows[j][70] = '#';
  for (std::size_t i = 20; i < 45; ++i) rows[30][i] = '#';
  for (std::size_t j = 50; j < 58; ++j) rows[j].replace(100, 9, "#########");
  for (std::size_t j = 70; j < 80; ++j) rows[j].replace(10, 12, "????????????");
  return grid_from_text(rows, 0.05, {-1.0, 2.0, yaw_rad});
}

/// What a LiDAR at the origin of the base sees; marching in small steps, for no caster of the library is to
/// be believed here.
inline Scan seen_from(const GridMap& map, const Pose& pose, std::size_t beams, double fov_rad,
                      double range_m) {
  Scan scan;
  scan.angle_min_rad = -0.5 * fov_rad;
  scan.angle_step_rad = fov_rad / static_cast<double>(beams);
  scan.range_min_m = 0.05;
  scan.range_max_m = range_m;
  for (std::size_t b = 0; b < beams; ++b) {
    const double angle = pose.theta_rad + scan.angle_min_rad + scan.angle_step_rad * static_cast<double>(b);
    double r = 0.0;
    while (r < range_m &&
           map.at_point(pose.x_m + r * std::cos(angle), pose.y_m + r * std::sin(angle)) != Cell::occupied)
      r += 0.01;
    scan.ranges_m.push_back(static_cast<float>(std::min(r, range_m)));
  }
  return scan;
}

inline BeamTable beams_of(const GridMap& map, const Scan& scan) {
  BeamTable table;
  BeamCounts counts;
  select_beams(scan, ScanConfig{}, default_sensor(SensorModel::beam), map.resolution_m, table, counts);
  return table;
}

inline const ComputeConfig kOnCpu{.backend = BackendChoice::cpu};

inline SearchConfig small_config() {
  SearchConfig c;
  c.beams = 37;  // not a whole number of fours
  c.heading_cells = 3.0;
  c.least_share = 0.7;
  return c;
}

inline Pose in_rooms(double x, double y, double theta) {
  return compose({-1.0, 2.0, 0.0}, {x, y, theta});
}

struct OneSearch {
  SearchMap map;
  SearchScan scan;
  SearchTask task;
};

inline OneSearch one_search(const GridMap& grid, const Scan& seen, bool with_prior) {
  const SearchConfig config = small_config();
  OneSearch s{make_search_map(grid, config), {}, {}};
  make_search_scan(beams_of(grid, seen), grid.resolution_m, s.map.cell_m, config, s.scan);
  s.task.beams = s.scan.beams;
  s.task.headings = s.task.heading_count = s.scan.headings;
  s.task.block_end_i = s.map.shape.blocks_x(), s.task.block_end_j = s.map.shape.blocks_y();
  s.task.least = 63u * static_cast<std::uint32_t>(s.scan.beams) / 3u;
  s.task.share_1024th = 700;
  if (with_prior) {
    s.task.first_heading = s.scan.headings - 11, s.task.heading_count = 35;
    s.task.block_i = 2, s.task.block_j = 1, s.task.block_end_i -= 3;
    s.task.region = {130, 90, 90 * 90};
  }
  return s;
}

inline const Pose kSomewhere = in_rooms(5.1, 0.9, -0.2);

}  // namespace test
}  // namespace parloc
