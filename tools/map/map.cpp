// parloc map: what is in a map, whether it is sound, what it looks like, and the same as another kind of map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/file/input_file.h"
#include "common/file/output_file.h"
#include "common/inputs/bag_map.h"
#include "common/map/check/known_part.h"
#include "common/map/check/map_findings.h"
#include "common/map/grid_map.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"
#include "common/map/rasterise.h"
#include "common/map/segment_map.h"
#include "common/map/trace_walls.h"
#include "tools/program/commands.h"
#include "tools/program/parse_number.h"
#include "tools/report/map_picture.h"

namespace parloc::tools {
namespace {

/// What a segment file held besides the walls that are used.
struct SegmentFacts {
  std::string title;  ///< May be empty.
  std::size_t zero_length = 0, duplicates = 0;
  bool enclosed = false;
};

/// A map of any kind, with what only its file knows.
struct LoadedMap {
  GridMap map;
  std::optional<SegmentFacts> segments;    ///< Of a segment map.
  std::vector<std::string> findings = {};  ///< Of a grid's image: what does not fit together.
};

/// As open_map(); `resolution_m` replaces that of a segment map and has no effect on others.
LoadedMap load_map(const std::string& path, std::optional<double> resolution_m = {}) {
  if (is_bag(path)) return {read_bag_map(path, {}), {}};
  const std::string text = read_input_file(path, path, kLongestSegmentFile + 1);
  if (!is_segment_text(text, path)) {
    ImageMap read = read_image_map(text, path);
    std::vector<std::string> findings = image_findings(read);
    return {std::move(read.map), {}, std::move(findings)};
  }
  SegmentMap segments = segment_map_from_text(text, path);
  if (resolution_m) segments.resolution_m = *resolution_m;
  PlacedSegments placed = place_segments(segments, path);
  return {std::move(placed.map),
          SegmentFacts{segments.name, placed.zero_length, placed.duplicates, placed.enclosed}};
}

double total_length_m(const GridMap& map) {
  double sum_m = 0.0;
  for (const GridWall& w : map.walls) sum_m += std::hypot(double{w.bx} - w.ax, double{w.by} - w.ay);
  return sum_m;
}

/// "2 of zero length, 1 duplicate"; empty if nothing was left out.
std::string left_out(const SegmentFacts& facts) {
  if (facts.zero_length + facts.duplicates == 0) return {};
  return fmt::format("{} of zero length, {} duplicate{}", facts.zero_length, facts.duplicates,
                     facts.duplicates == 1 ? "" : "s");
}

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
  for (const std::string& note : map.notes) fmt::print("{:<12}{}\n", "note", note);
}

/// Prints what is odd. A map that cannot be read has thrown before; one without a free cell throws here.
int check(const LoadedMap& loaded) {
  const GridMap& map = loaded.map;
  if (count_of(map, Cell::free) == 0) {
    const std::string why = loaded.findings.empty() ? "" : ": " + loaded.findings.front();
    throw input_error(map.name, 0, "expected a free cell, where a robot can be, found none" + why);
  }
  for (const std::string& note : map.notes) fmt::print("note: {}\n", note);
  std::vector<std::string> notes = loaded.findings;
  if (count_of(map, Cell::occupied) == 0) notes.push_back("no cell is occupied: there is nothing to see");
  if (loaded.segments) {
    if (const std::string dropped = left_out(*loaded.segments); !dropped.empty())
      notes.push_back(dropped + " left out");
    if (!loaded.segments->enclosed) notes.push_back("the walls form no closed ring: nothing is unknown");
  }
  if (!loaded.segments)
    for (std::string& finding : grid_findings(map)) notes.push_back(std::move(finding));
  for (const std::string& note : notes) fmt::print("{}: note: {}\n", map.name, note);
  fmt::print("{}: sound, {}\n", map.name,
             loaded.segments ? fmt::format("{} segments", map.walls.size())
                             : fmt::format("{} x {} cells", map.width, map.height));
  return 0;
}

/// As on the command line; empty: not given.
struct ConvertMapOptions {
  std::string in, out, to, resolution, max_error, picture;
  bool unknown_blocks = false, crop = false;
};

constexpr double kMostError_m = 1e3;

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorKind::usage, "map convert: " + message);
}

void print_walls(const std::string& path, const GridMap& map, const std::string& note) {
  fmt::print("{:<12}{}: {} segments, {:.2f} m{}\n", "walls", path, map.walls.size(), total_length_m(map),
             note.empty() ? "" : "; " + note);
}

void print_source(const LoadedMap& loaded, const std::string& path) {
  const std::string dropped = left_out(*loaded.segments);
  print_walls(path, loaded.map, dropped.empty() ? "" : dropped + " left out");
}

void print_grid(const std::string& path, const GridMap& map) {
  fmt::print("{:<12}{}: {} x {} cells of {} m, {} occupied\n", "grid", path, map.width, map.height,
             map.resolution_m, std::count(map.cells.begin(), map.cells.end(), Cell::occupied));
}

void walls_to_grid(const ConvertMapOptions& o, const LoadedMap& loaded) {
  write_map(o.out, loaded.map);
  print_source(loaded, o.in);
  print_grid(o.out, loaded.map);
  fmt::print("{:<12}occupied cells are at most {:.4f} m from a wall (half a diagonal); measured {:.4f} m\n",
             "error", 0.70711 * loaded.map.resolution_m, raster_error_m(loaded.map));
}

void grid_to_walls(const ConvertMapOptions& o, GridMap& map, double max_error_m) {
  TracedWalls traced = trace_walls(map, max_error_m, o.unknown_blocks);
  if (traced.walls.empty()) {
    throw input_error(o.in, 0, "expected a wall to trace: no blocking cell has another beside it");
  }
  if (traced.walls.size() > kMostSegments) {
    throw input_error(o.in, 0,
                      fmt::format("has {} walls, and a segment map has at most {}: give a larger --max-error",
                                  traced.walls.size(), kMostSegments));
  }
  map.walls = std::move(traced.walls);
  write_segment_map(o.out, map);
  print_grid(o.in, map);
  print_walls(o.out, map, fmt::format("{} straight runs of cell faces", traced.faces));
  fmt::print("{:<12}at most {} m allowed, {:.4f} m measured\n", "error", max_error_m, traced.error_m);
}

void walls_to_walls(const ConvertMapOptions& o, const LoadedMap& loaded) {
  write_segment_map(o.out, loaded.map, loaded.segments->title);
  print_source(loaded, o.in);
  fmt::print("{:<12}{}: the same\n", "walls", o.out);
}

constexpr std::int32_t kCropMargin = 1;  ///< [cells]

void crop_grid(const ConvertMapOptions& o, LoadedMap& loaded) {
  GridMap part = cropped(loaded.map, kCropMargin);
  print_grid(o.in, loaded.map);
  loaded.map = std::move(part);
  write_map(o.out, loaded.map);
  print_grid(o.out, loaded.map);
}

void refuse_own_input(const ConvertMapOptions& o) {
  std::error_code error;
  if (std::filesystem::equivalent(o.in, o.out, error) && !error) refuse("OUT is the file that IN is");
}

/// A name that parloc would read as another kind of map, or not at all, is a slip of the finger.
void refuse_other_endings(const std::string& out, bool walls) {
  const std::string ending = std::filesystem::path(out).extension().string();
  if (ending == ".yaml" || ending == ".yml") return;
  if (walls && is_geojson("", out)) return;
  refuse(walls ? fmt::format("expected OUT to end in .yaml, .yml, .geojson or .json, got '{}'", out)
               : fmt::format("expected OUT to be a name such as map.yaml for a grid, got '{}'", out));
}

/// Gives the exit code; throws Error.
int convert_map(const ConvertMapOptions& o) {
  std::optional<double> resolution_m;
  if (!o.resolution.empty())
    resolution_m = parse_number("--resolution", o.resolution, kFinestResolution_m, kCoarsestResolution_m);
  const double max_error_m =
      o.max_error.empty() ? 0.0 : parse_number("--max-error", o.max_error, 0.0, kMostError_m);
  refuse_own_input(o);
  LoadedMap loaded = load_map(o.in, resolution_m);
  const bool from_walls = loaded.segments.has_value();
  const bool to_walls = o.to.empty() ? (!from_walls && !o.crop) || is_geojson("", o.out) : o.to == "segments";
  if (o.crop && (from_walls || to_walls)) refuse("--crop makes a grid of a grid");
  if (o.crop && (!o.max_error.empty() || o.unknown_blocks))
    refuse("--crop moves no wall: it takes no other option");
  if (!from_walls && !to_walls && !o.crop) refuse(o.in + " is a grid already");
  if (!from_walls && resolution_m) refuse("--resolution is for segments only; the cells of a grid stay");
  if (from_walls && (!o.max_error.empty() || o.unknown_blocks))
    refuse("--max-error and --unknown-blocks are for a grid only");
  refuse_other_endings(o.out, to_walls);
  if (!o.picture.empty()) expect_writable(o.picture);
  if (o.crop) {
    crop_grid(o, loaded);
  } else if (!from_walls) {
    grid_to_walls(o, loaded.map, max_error_m);
  } else if (to_walls) {
    walls_to_walls(o, loaded);
  } else {
    walls_to_grid(o, loaded);
  }
  if (!o.picture.empty()) {
    write_map_picture(o.picture, loaded.map);
    fmt::print("{:<12}{}\n", "picture", o.picture);
  }
  return 0;
}

void add_map_argument(CLI::App& app, std::string& target) {
  add_text_option(app, "MAP", target, "FILE", "map_server YAML, or segments (YAML, GeoJSON)")->required();
}

CLI::App* add_convert(CLI::App& map, ConvertMapOptions& o) {
  CLI::App* app = map.add_subcommand("convert", "Make a grid of segments or the reverse, or crop a grid");
  add_text_option(*app, "IN", o.in, "FILE", "A map of either kind")->required();
  add_text_option(*app, "OUT", o.out, "FILE", ".yaml, or .geojson for segments")->required();
  add_text_option(*app, "--resolution", o.resolution, "M", "Cell size of the grid (as IN says)");
  add_text_option(*app, "--max-error", o.max_error, "M", "Simplify traced walls by so much (0)");
  app->add_flag("--unknown-blocks", o.unknown_blocks, "Unknown cells are walls, too");
  app->add_flag("--crop", o.crop, "Of a grid: without the border of unknown");
  add_text_option(*app, "--to", o.to, "KIND", "grid or segments (what IN is not)")
      ->check(CLI::IsMember({"grid", "segments"}));
  add_text_option(*app, "--picture", o.picture, "P.png", "Draw both on top of each other");
  app->footer("A grid is written as OUT.yaml with OUT.pgm beside it. docs/maps.md");
  return app;
}

struct MapOptions {
  std::string path, picture;
  ConvertMapOptions convert;
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
  return {app, [=](const std::string&) {
            if (convert->parsed()) return convert_map(o->convert);
            const LoadedMap loaded = load_map(o->path);
            if (checking->parsed()) return check(loaded);
            if (info->parsed()) print_info(loaded);
            if (show->parsed()) write_map_picture(o->picture, loaded.map);
            return 0;
          }};
}

}  // namespace parloc::tools
