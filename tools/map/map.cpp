// parloc map: what is in a map, whether it is sound, what it looks like, and the same as another kind of map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/map/grid_map.h"
#include "common/map/segment_map.h"
#include "tools/map/convert_map.h"
#include "tools/program/commands.h"
#include "tools/program/load_map.h"
#include "tools/program/text_option.h"
#include "tools/report/map_picture.h"

namespace parloc::tools {
namespace {

std::ptrdiff_t count_of(const GridMap& map, Cell kind) {
  return std::count(map.cells.begin(), map.cells.end(), kind);
}

void print_cells(const GridMap& map, const char* name, Cell kind) {
  const auto count = static_cast<double>(count_of(map, kind));
  const double share = 100.0 * count / static_cast<double>(map.size());
  fmt::print("{:<12}{} cells, {:.1f} %, {:.1f} m2\n", name, count, share,
             count * map.resolution_m * map.resolution_m);
}

/// What points of the grid frame span in the map frame.
void print_span(const char* name, const GridMap& map, const std::vector<MapPoint>& points) {
  double x_min = std::numeric_limits<double>::infinity(), y_min = x_min, x_max = -x_min, y_max = -x_min;
  for (const MapPoint& point : points) {
    Pose in_map = compose(map.T_map_grid, {point.x_m, point.y_m, 0.0});
    for (double* value : {&in_map.x_m, &in_map.y_m}) {
      if (std::fabs(*value) < 0.005) *value = 0.0;  // not "-0.00"
    }
    x_min = std::min(x_min, in_map.x_m), x_max = std::max(x_max, in_map.x_m);
    y_min = std::min(y_min, in_map.y_m), y_max = std::max(y_max, in_map.y_m);
  }
  fmt::print("{:<12}x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m\n", name, x_min, x_max, y_min, y_max);
}

void print_walls(const GridMap& map, const SegmentFacts& facts) {
  double shortest_m = std::numeric_limits<double>::infinity(), longest_m = 0.0;
  std::vector<MapPoint> ends;
  for (const GridWall& w : map.walls) {
    const double length_m = std::hypot(double{w.bx} - w.ax, double{w.by} - w.ay);
    shortest_m = std::min(shortest_m, length_m), longest_m = std::max(longest_m, length_m);
    ends.insert(ends.end(), {{w.ax, w.ay}, {w.bx, w.by}});
  }
  if (!facts.title.empty()) fmt::print("{:<12}{}\n", "name", facts.title);
  fmt::print("{:<12}{} segments, {:.2f} m in all, from {:.4g} to {:.4g} m long\n", "walls", map.walls.size(),
             total_length_m(map), shortest_m, longest_m);
  if (const std::string dropped = left_out(facts); !dropped.empty())
    fmt::print("{:<12}{}\n", "left out", dropped);
  print_span("walls span", map, ends);
  fmt::print("{:<12}{}\n", "ring",
             facts.enclosed ? "closed: outside of it is unknown" : "not closed: nothing is unknown");
}

void print_info(const LoadedMap& loaded) {
  const GridMap& map = loaded.map;
  const double length_m = map.width * map.resolution_m, height_m = map.height * map.resolution_m;
  const Pose& origin = map.T_map_grid;
  fmt::print("map         {}\n", map.name);
  if (loaded.segments) print_walls(map, *loaded.segments);
  fmt::print("size        {} x {} cells, {:.2f} x {:.2f} m\n", map.width, map.height, length_m, height_m);
  fmt::print("resolution  {} m\n", map.resolution_m);
  fmt::print("origin      x {} m, y {} m, yaw {} rad (lower-left corner)\n", origin.x_m, origin.y_m,
             origin.theta_rad);
  print_span("spans", map, {{0, 0}, {length_m, 0}, {0, height_m}, {length_m, height_m}});
  print_cells(map, "free", Cell::free);
  print_cells(map, "occupied", Cell::occupied);
  print_cells(map, "unknown", Cell::unknown);
}

/// Prints what is odd. A map that cannot be read has thrown before; one without a free cell throws here.
int check(const LoadedMap& loaded) {
  const GridMap& map = loaded.map;
  if (count_of(map, Cell::free) == 0)
    throw input_error(map.name, 0, "expected a free cell, where a robot can be, found none");
  std::vector<std::string> notes;
  if (count_of(map, Cell::occupied) == 0) notes.push_back("no cell is occupied: there is nothing to see");
  if (loaded.segments) {
    if (const std::string dropped = left_out(*loaded.segments); !dropped.empty())
      notes.push_back(dropped + " left out");
    if (!loaded.segments->enclosed) notes.push_back("the walls form no closed ring: nothing is unknown");
  }
  for (const std::string& note : notes) fmt::print("{}: note: {}\n", map.name, note);
  fmt::print("{}: sound, {}\n", map.name,
             loaded.segments ? fmt::format("{} segments", map.walls.size())
                             : fmt::format("{} x {} cells", map.width, map.height));
  return 0;
}

void add_map_argument(CLI::App& app, std::string& target) {
  add_text_option(app, "MAP", target, "FILE", "map_server YAML, or segments (YAML, GeoJSON)")->required();
}

CLI::App* add_convert(CLI::App& map, ConvertOptions& o) {
  CLI::App* app = map.add_subcommand("convert", "Make a grid of segments, or segments of a grid");
  add_text_option(*app, "IN", o.in, "FILE", "A map of either kind")->required();
  add_text_option(*app, "OUT", o.out, "FILE", ".yaml, or .geojson for segments")->required();
  add_text_option(*app, "--resolution", o.resolution, "M", "Cell size of the grid (as IN says)");
  add_text_option(*app, "--max-error", o.max_error, "M", "Simplify traced walls by so much (0)");
  app->add_flag("--unknown-blocks", o.unknown_blocks, "Unknown cells are walls, too");
  add_text_option(*app, "--to", o.to, "KIND", "grid or segments (what IN is not)")
      ->check(CLI::IsMember({"grid", "segments"}));
  add_text_option(*app, "--picture", o.picture, "P.png", "Draw both on top of each other");
  app->footer("A grid is written as OUT.yaml with OUT.pgm beside it. docs/maps.md");
  return app;
}

struct MapOptions {
  std::string path, picture;
  ConvertOptions convert;
};

}  // namespace

Command add_map_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("map", "Inspect, check, convert or draw a map");
  app->require_subcommand(1);
  const auto o = std::make_shared<MapOptions>();
  CLI::App* info = app->add_subcommand("info", "Print a map's size, place and contents");
  add_map_argument(*info, o->path);
  CLI::App* checking = app->add_subcommand("check", "Say whether a map is sound; else exit code 3");
  add_map_argument(*checking, o->path);
  CLI::App* convert = add_convert(*app, o->convert);
  CLI::App* show = app->add_subcommand("show", "Draw a map");
  add_map_argument(*show, o->path);
  add_text_option(*show, "--out", o->picture, "P.png", "The picture")->required();
  return {app, [=] {
            if (convert->parsed()) return convert_map(o->convert);
            const LoadedMap loaded = load_map(o->path);
            if (checking->parsed()) return check(loaded);
            if (info->parsed()) print_info(loaded);
            if (show->parsed()) write_map_picture(o->picture, loaded.map);
            return 0;
          }};
}

}  // namespace parloc::tools
