// parloc map: what is in a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "common/map/grid_map.h"
#include "common/map/map_reader.h"
#include "tools/commands.h"
#include "tools/text_option.h"

namespace parloc::tools {
namespace {

void print_cells(const GridMap& map, const char* name, Cell kind) {
  const auto count = std::count(map.cells.begin(), map.cells.end(), kind);
  const double share = 100.0 * static_cast<double>(count) / static_cast<double>(map.size());
  fmt::print("{:<12}{} cells, {:.1f} %, {:.1f} m2\n", name, count, share,
             static_cast<double>(count) * map.resolution_m * map.resolution_m);
}

void print_info(const GridMap& map) {
  const double length_m = map.width * map.resolution_m, height_m = map.height * map.resolution_m;
  const Pose& origin = map.T_map_grid;
  double x_min = origin.x_m, x_max = origin.x_m, y_min = origin.y_m, y_max = origin.y_m;
  for (const Pose corner : {Pose{length_m, 0, 0}, Pose{0, height_m, 0}, Pose{length_m, height_m, 0}}) {
    const Pose in_map = compose(origin, corner);
    x_min = std::min(x_min, in_map.x_m), x_max = std::max(x_max, in_map.x_m);
    y_min = std::min(y_min, in_map.y_m), y_max = std::max(y_max, in_map.y_m);
  }
  fmt::print("map         {}\n", map.name);
  fmt::print("size        {} x {} cells, {:.2f} x {:.2f} m\n", map.width, map.height, length_m, height_m);
  fmt::print("resolution  {} m\n", map.resolution_m);
  fmt::print("origin      x {} m, y {} m, yaw {} rad (lower-left corner)\n", origin.x_m, origin.y_m,
             origin.theta_rad);
  fmt::print("spans       x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m\n", x_min, x_max, y_min, y_max);
  print_cells(map, "free", Cell::free);
  print_cells(map, "occupied", Cell::occupied);
  print_cells(map, "unknown", Cell::unknown);
}

}  // namespace

Command add_map_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("map", "Inspect a map");
  app->require_subcommand(1);
  CLI::App* info = app->add_subcommand("info", "Print a map's size, place and contents");
  const auto path = std::make_shared<std::string>();
  add_text_option(*info, "MAP", *path, "M.yaml", "ROS map_server YAML")->required();
  return {app, [path] {
            print_info(read_map(*path));
            return 0;
          }};
}

}  // namespace parloc::tools
