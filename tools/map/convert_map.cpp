#include "tools/map/convert_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "common/error.h"
#include "common/file/output_file.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"
#include "common/map/rasterise.h"
#include "common/map/segment_map.h"
#include "common/map/trace_walls.h"
#include "tools/program/load_map.h"
#include "tools/program/parse_number.h"
#include "tools/report/map_picture.h"

namespace parloc::tools {
namespace {

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

void walls_to_grid(const ConvertOptions& o, const LoadedMap& loaded) {
  write_map(o.out, loaded.map);
  print_source(loaded, o.in);
  print_grid(o.out, loaded.map);
  fmt::print("{:<12}occupied cells are at most {:.4f} m from a wall (half a diagonal); measured {:.4f} m\n",
             "error", 0.70711 * loaded.map.resolution_m, raster_error_m(loaded.map));
}

void grid_to_walls(const ConvertOptions& o, GridMap& map, double max_error_m) {
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

void walls_to_walls(const ConvertOptions& o, const LoadedMap& loaded) {
  write_segment_map(o.out, loaded.map, loaded.segments->title);
  print_source(loaded, o.in);
  fmt::print("{:<12}{}: the same\n", "walls", o.out);
}

void refuse_own_input(const ConvertOptions& o) {
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

}  // namespace

int convert_map(const ConvertOptions& o) {
  std::optional<double> resolution_m;
  if (!o.resolution.empty())
    resolution_m = parse_number("--resolution", o.resolution, kFinestResolution_m, kCoarsestResolution_m);
  const double max_error_m =
      o.max_error.empty() ? 0.0 : parse_number("--max-error", o.max_error, 0.0, kMostError_m);
  refuse_own_input(o);
  LoadedMap loaded = load_map(o.in, resolution_m);
  const bool from_walls = loaded.segments.has_value();
  const bool to_walls = o.to.empty() ? !from_walls || is_geojson("", o.out) : o.to == "segments";
  if (!from_walls && !to_walls) refuse(o.in + " is a grid already");
  if (!from_walls && resolution_m) refuse("--resolution is for segments only; the cells of a grid stay");
  if (from_walls && (!o.max_error.empty() || o.unknown_blocks))
    refuse("--max-error and --unknown-blocks are for a grid only");
  refuse_other_endings(o.out, to_walls);
  if (!o.picture.empty()) expect_writable(o.picture);
  if (!from_walls) {
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

}  // namespace parloc::tools
