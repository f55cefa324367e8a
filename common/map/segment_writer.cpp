// GridWall maps as YAML and as GeoJSON, in the map frame.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/error.h"
#include "common/file/output_file.h"
#include "common/map/segment_map.h"

namespace parloc {
namespace {

/// A point of a wall as it is written, and where it lies in the grid.
struct WrittenPoint {
  float x, y;
  std::string text;  ///< "[x, y]" in the map frame.
};

/// The shortest decimal number that is within `tolerance` of `value`.
std::string shortest_decimal(double value, double tolerance) {
  for (int digits = 0; digits <= 9; ++digits) {
    const std::string text = fmt::format("{:.{}f}", value, digits);
    double back = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    if (std::fabs(back - value) <= tolerance) return back == 0.0 ? "0" : text;
  }
  return fmt::format("{:.9f}", value);
}

/// A little less than what changes a float of this size [m].
double float_tolerance(float value) {
  const float size = std::fabs(value);
  return std::max(1e-9, 0.49 * (std::nextafter(size, std::numeric_limits<float>::infinity()) - size));
}

WrittenPoint written(float x, float y, const Pose& T_map_grid) {
  const Pose in_map = compose(T_map_grid, {x, y, 0.0});
  double tolerance_x = float_tolerance(x), tolerance_y = float_tolerance(y);
  if (T_map_grid.theta_rad != 0.0) tolerance_x = tolerance_y = 0.5 * std::min(tolerance_x, tolerance_y);
  return {x, y,
          "[" + shortest_decimal(in_map.x_m, tolerance_x) + ", " + shortest_decimal(in_map.y_m, tolerance_y) +
              "]"};
}

/// Walls that follow each other.
struct Chain {
  std::vector<WrittenPoint> points;  ///< Without the first one again at the end.
  bool closed = false;
};

/// Calls take(chain) for each, in the order of the walls.
template <class Take>
void for_each_chain(const GridMap& map, Take&& take) {
  const auto point = [&](float x, float y) { return written(x, y, map.T_map_grid); };
  Chain chain;
  const auto finish = [&] {
    if (!chain.points.empty()) take(std::as_const(chain));
    chain = {};
  };
  for (const GridWall& wall : map.walls) {
    const bool joins = !chain.points.empty() && !chain.closed && chain.points.back().x == wall.ax &&
                       chain.points.back().y == wall.ay;
    if (!joins) {
      finish();
      chain.points.push_back(point(wall.ax, wall.ay));
    }
    chain.closed =
        chain.points.size() > 2 && chain.points.front().x == wall.bx && chain.points.front().y == wall.by;
    if (!chain.closed) chain.points.push_back(point(wall.bx, wall.by));
  }
  finish();
}

/// "[[x, y], [x, y]]"
std::string list_of(const Chain& chain, bool repeat_first) {
  std::string list = "[";
  for (const WrittenPoint& p : chain.points) list += (list.size() > 1 ? ", " : "") + p.text;
  if (repeat_first) list += ", " + chain.points.front().text;
  return list + "]";
}

/// A text in double quotes as JSON has it, which YAML reads too; bytes that are no UTF-8 are replaced.
std::string json_text(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

void refuse_no_walls(const GridMap& map) {
  if (map.walls.empty())
    throw Error(ErrorKind::output, map.name + ": has no walls to write: expected a segment map");
  validate(map);
}

}  // namespace

std::string segment_yaml_of(const GridMap& map, const std::string& name) {
  refuse_no_walls(map);
  std::string segments, polylines, polygons;
  for_each_chain(map, [&](const Chain& chain) {
    if (chain.closed) {
      polygons += "  - " + list_of(chain, false) + "\n";
    } else if (chain.points.size() > 2) {
      polylines += "  - " + list_of(chain, false) + "\n";
    } else {
      const auto& [a, b] = std::pair(chain.points[0].text, chain.points[1].text);
      segments += "  - " + a.substr(0, a.size() - 1) + ", " + b.substr(1) + "\n";
    }
  });
  std::string text = fmt::format("# Walls in metres, map frame.\n{}resolution: {}\n",
                                 name.empty() ? "" : "name: " + json_text(name) + "\n", map.resolution_m);
  if (!segments.empty()) text += "segments:\n" + segments;
  if (!polylines.empty()) text += "polylines:\n" + polylines;
  if (!polygons.empty()) text += "polygons:\n" + polygons;
  return text;
}

std::string geojson_of(const GridMap& map, const std::string& name) {
  refuse_no_walls(map);
  std::string text = fmt::format("{{\"type\": \"FeatureCollection\", {}\"resolution\": {}, \"features\": [",
                                 name.empty() ? "" : "\"name\": " + json_text(name) + ", ", map.resolution_m);
  bool first = true;
  for_each_chain(map, [&](const Chain& chain) {
    text += first ? "\n" : ",\n";
    first = false;
    text += "{\"type\": \"Feature\", \"properties\": {}, \"geometry\": {\"type\": ";
    text += chain.closed ? "\"Polygon\", \"coordinates\": [" + list_of(chain, true) + "]}}"
                         : "\"LineString\", \"coordinates\": " + list_of(chain, false) + "}}";
  });
  return text + "\n]}\n";
}

void write_segment_map(const std::string& path, const GridMap& map, const std::string& name) {
  replace_file(path, is_geojson("", path) ? geojson_of(map, name) : segment_yaml_of(map, name));
}

}  // namespace parloc
