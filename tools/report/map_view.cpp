#include "tools/report/map_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/error.h"

namespace parloc::tools {
namespace {

/// An axis-parallel box in the grid's frame [m]; empty when low > high.
struct Box {
  double low_x = std::numeric_limits<double>::infinity(), low_y = low_x;
  double high_x = -low_x, high_y = -low_x;

  bool empty() const { return low_x > high_x; }
  double longest_side() const { return empty() ? 0.0 : std::max(high_x - low_x, high_y - low_y); }
  void add(double x, double y) {
    low_x = std::min(low_x, x), high_x = std::max(high_x, x);
    low_y = std::min(low_y, y), high_y = std::max(high_y, y);
  }
};

Box grown(const Box& box, double by_x, double by_y) {
  return box.empty() ? box : Box{box.low_x - by_x, box.low_y - by_y, box.high_x + by_x, box.high_y + by_y};
}

Box united(const Box& a, const Box& b) {
  return {std::min(a.low_x, b.low_x), std::min(a.low_y, b.low_y), std::max(a.high_x, b.high_x),
          std::max(a.high_y, b.high_y)};
}

Box common_part(const Box& a, const Box& b) {
  const Box part = {std::max(a.low_x, b.low_x), std::max(a.low_y, b.low_y), std::min(a.high_x, b.high_x),
                    std::min(a.high_y, b.high_y)};
  return part.low_x > part.high_x || part.low_y > part.high_y ? Box{} : part;
}

struct GridPoint {
  double x, y;
};

GridPoint to_grid(const Pose& T_map_grid, double x_m, double y_m) {
  const double c = std::cos(T_map_grid.theta_rad), s = std::sin(T_map_grid.theta_rad);
  const double dx = x_m - T_map_grid.x_m, dy = y_m - T_map_grid.y_m;
  return {c * dx + s * dy, c * dy - s * dx};
}

Box box_of(const Trajectory& path, const Pose& T_map_grid) {
  Box box;
  for (const StampedPose& p : path) {
    if (!drawable_point(p.pose.x_m, p.pose.y_m)) continue;
    const GridPoint g = to_grid(T_map_grid, p.pose.x_m, p.pose.y_m);
    box.add(g.x, g.y);
  }
  return box;
}

/// The box around the cells that are not unknown; around all cells if there is no such cell.
Box known_box(const GridMap& map) {
  std::int32_t low_i = map.width, high_i = -1, low_j = map.height, high_j = -1;
  for (std::int32_t j = 0; j < map.height; ++j) {
    const Cell* row = map.cells.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width);
    const auto known = [](Cell c) { return c != Cell::unknown; };
    const Cell* first = std::find_if(row, row + map.width, known);
    if (first == row + map.width) continue;
    const Cell* last = row + map.width;
    while (!known(*(last - 1))) --last;
    low_i = std::min(low_i, static_cast<std::int32_t>(first - row));
    high_i = std::max(high_i, static_cast<std::int32_t>(last - row));
    low_j = std::min(low_j, j), high_j = j + 1;
  }
  if (high_i < 0) low_i = low_j = 0, high_i = map.width, high_j = map.height;
  const double r = map.resolution_m;
  return {low_i * r, low_j * r, high_i * r, high_j * r};
}

void check(const GridMap& map) {
  const bool fits =
      map.width > 0 && map.height > 0 && map.resolution_m >= 1e-6 && map.resolution_m <= 1e6 &&
      drawable_point(map.T_map_grid.x_m, map.T_map_grid.y_m) && std::isfinite(map.T_map_grid.theta_rad) &&
      map.cells.size() == static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  if (!fits) {
    throw Error(ErrorKind::output, "report: the map has " + std::to_string(map.cells.size()) +
                                       " cells, width " + std::to_string(map.width) + ", height " +
                                       std::to_string(map.height) + ", resolution " +
                                       std::to_string(map.resolution_m) + " m");
  }
}

/// The part of the plane to show. `known` is empty without a map.
Box area_of_interest(const RunReport& report, const Pose& T_map_grid, const Box& known) {
  Box core = box_of(report.estimate, T_map_grid);
  if (report.truth) core = united(core, box_of(*report.truth, T_map_grid));
  const Box odometry = box_of(report.odometry, T_map_grid);
  if (core.empty()) core = known.empty() ? odometry : known;
  if (core.empty()) return core;
  const double side = core.longest_side();
  const double margin = std::max(2.5, 0.12 * side);
  // Dead reckoning may end far away: it widens the window by a quarter at most.
  const Box drift = common_part(grown(odometry, 0.3 * margin, 0.3 * margin), grown(core, side / 4, side / 4));
  Box area = united(grown(core, margin, margin), drift);
  const double least = 0.4 * area.longest_side();  // a corridor is not shown as a thin strip
  area = grown(area, std::max(0.0, (least - (area.high_x - area.low_x)) / 2),
               std::max(0.0, (least - (area.high_y - area.low_y)) / 2));
  if (known.empty()) return area;
  if (known.longest_side() <= 1.6 * area.longest_side()) area = united(area, grown(known, 0.3, 0.3));
  return common_part(area, united(grown(known, 0.3, 0.3), united(core, drift)));
}

}  // namespace

bool drawable_point(double x_m, double y_m) {
  return std::abs(x_m) < 1e7 && std::abs(y_m) < 1e7;
}

Pixel MapView::to_pixel(double x_m, double y_m) const {
  const GridPoint g = to_grid(T_map_grid, x_m, y_m);
  const double scale = static_cast<double>(up) / static_cast<double>(down);
  return {(g.x / cell_m - static_cast<double>(first_i)) * scale,
          height_px - (g.y / cell_m - static_cast<double>(first_j)) * scale};
}

std::optional<MapView> fit_view(const RunReport& report, std::int32_t least_px, std::int32_t most_px) {
  MapView view;
  Box known;
  if (report.map != nullptr) {
    check(*report.map);
    view.T_map_grid = report.map->T_map_grid;
    view.cell_m = report.map->resolution_m;
    known = known_box(*report.map);
  }
  const Box area = area_of_interest(report, view.T_map_grid, known);
  if (area.empty()) return std::nullopt;
  if (report.map == nullptr) view.cell_m = area.longest_side() / 800;
  view.first_i = static_cast<std::int64_t>(std::floor(area.low_x / view.cell_m));
  view.first_j = static_cast<std::int64_t>(std::floor(area.low_y / view.cell_m));
  const auto cells_x = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(area.high_x / view.cell_m)) - view.first_i);
  const auto cells_y = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(area.high_y / view.cell_m)) - view.first_j);
  const std::int64_t longest = std::max(cells_x, cells_y);
  view.down = (longest + most_px - 1) / most_px;
  if (view.down == 1 && longest < least_px) {
    const std::int64_t wanted = (least_px + longest - 1) / longest;
    view.up = static_cast<std::int32_t>(std::max<std::int64_t>(1, std::min(wanted, most_px / longest)));
  }
  view.width_px = static_cast<std::int32_t>((cells_x + view.down - 1) / view.down * view.up);
  view.height_px = static_cast<std::int32_t>((cells_y + view.down - 1) / view.down * view.up);
  return view;
}

MapView view_to_write(const std::string& path, const RunReport& report, std::int32_t least_px,
                      std::int32_t most_px) {
  const std::optional<MapView> view = fit_view(report, least_px, most_px);
  if (!view) throw Error(ErrorKind::output, path + ": cannot be written: neither a map nor a path to show");
  return *view;
}

std::vector<Cell> raster(const GridMap& map, const MapView& view) {
  struct Count {
    std::uint32_t occupied = 0, free = 0, unknown = 0;  // per pixel at most the cells of one map: below 2^30
  };
  const std::int64_t columns = view.width_px / view.up, rows = view.height_px / view.up;
  const std::int64_t begin_i = std::max<std::int64_t>(0, view.first_i);
  const std::int64_t end_i = std::min<std::int64_t>(map.width, view.first_i + columns * view.down);
  std::vector<Cell> pixels(static_cast<std::size_t>(view.width_px) * static_cast<std::size_t>(view.height_px),
                           Cell::unknown);
  std::vector<Count> counts;
  for (std::int64_t row = 0; row < rows; ++row) {
    counts.assign(static_cast<std::size_t>(columns), Count{});
    const std::int64_t begin_j = std::max<std::int64_t>(0, view.first_j + row * view.down);
    const std::int64_t end_j = std::min<std::int64_t>(map.height, view.first_j + (row + 1) * view.down);
    for (std::int64_t j = begin_j; j < end_j; ++j) {
      for (std::int64_t i = begin_i; i < end_i; ++i) {
        Count& count = counts[static_cast<std::size_t>((i - view.first_i) / view.down)];
        const Cell cell = map.cells[static_cast<std::size_t>(j * map.width + i)];
        (cell == Cell::occupied ? count.occupied : cell == Cell::free ? count.free : count.unknown) += 1;
      }
    }
    for (std::int32_t k = 0; k < view.up; ++k) {
      Cell* out = pixels.data() + (view.height_px - 1 - row * view.up - k) * view.width_px;
      for (std::int64_t x = 0; x < view.width_px; ++x) {
        const Count& count = counts[static_cast<std::size_t>(x / view.up)];
        if (count.occupied > 0)
          out[x] = Cell::occupied;
        else if (count.free > 0 && count.free >= count.unknown)
          out[x] = Cell::free;
      }
    }
  }
  return pixels;
}

double scale_bar_m(const MapView& view) {
  const double limit_m = view.width_px * view.pixel_m() / 5;
  const double decade = std::pow(10.0, std::floor(std::log10(limit_m)));
  if (5 * decade <= limit_m) return 5 * decade;
  return 2 * decade <= limit_m ? 2 * decade : decade;
}

}  // namespace parloc::tools
