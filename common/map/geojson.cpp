// GridWall maps in GeoJSON (RFC 7946), its coordinates taken as metres of the map frame.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/file/text_fields.h"
#include "common/map/map_limits.h"
#include "common/map/segment_map.h"
#include "common/map/wall_collector.h"

namespace parloc {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 9> kTypes = {
    "FeatureCollection", "Feature", "GeometryCollection", "LineString", "MultiLineString", "Polygon",
    "MultiPolygon",      "Point",   "MultiPoint"};
constexpr int kDeepestCollection = 16;  // collections in collections; RFC 7946 advises against any

/// The line that a byte stands on.
std::size_t line_of(const std::string& text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

/// Walks through a document; `place` is where it stands, such as "features[3].geometry".
class GeojsonWalk {
 public:
  explicit GeojsonWalk(const std::string& file) : file_(file) {}

  SegmentMap walk(const Json& document) {
    if (!document.is_object()) fail("", "expected a GeoJSON object");
    read_extras(document);
    read_object(document, "", 0);
    map_.lines = guarded("", [&] { return walls_.take(); });
    return std::move(map_);
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& message) const {
    throw input_error(file_, 0, place.empty() ? message : place + ": " + message);
  }
  template <class Work>
  auto guarded(const std::string& place, Work&& work) const -> decltype(work()) {
    try {
      return work();
    } catch (const BrokenWall& broken) {
      fail(place, broken.why);
    }
  }
  static std::string within(const std::string& place, const std::string& member) {
    return place.empty() ? member : place + "." + member;
  }

  /// The two members that GeoJSON does not know, as write_segment_map() writes them; others are ignored.
  void read_extras(const Json& document) {
    const auto name = document.find("name");
    if (name != document.end() && name->is_string()) map_.name = name->get<std::string>();
    const auto resolution = document.find("resolution");
    if (resolution == document.end()) return;
    if (resolution->is_number()) map_.resolution_m = resolution->get<double>();
    if (!resolution->is_number() ||
        !(map_.resolution_m >= kFinestResolution_m && map_.resolution_m <= kCoarsestResolution_m)) {
      fail("resolution", fmt::format("must be {:g} to {:g} m", kFinestResolution_m, kCoarsestResolution_m));
    }
  }

  const Json& list_in(const Json& object, const char* member, const std::string& place) const {
    const auto found = object.find(member);
    if (found == object.end() || !found->is_array()) fail(place, fmt::format("expected a list '{}'", member));
    return *found;
  }

  std::string type_of(const Json& object, const std::string& place) const {
    if (!object.is_object()) fail(place, "expected an object with a 'type'");
    const auto type = object.find("type");
    if (type == object.end() || !type->is_string()) fail(place, "expected a 'type' that is a text");
    return type->get<std::string>();
  }

  void read_object(const Json& object, const std::string& place, int depth) {
    const std::string type = type_of(object, place);
    if (type == "FeatureCollection" && depth == 0) {
      std::size_t k = 0;
      for (const Json& feature : list_in(object, "features", place))
        read_feature(feature, fmt::format("features[{}]", k++));
    } else if (type == "Feature" && depth == 0) {
      read_feature(object, place);
    } else {
      read_geometry(object, type, place, depth);
    }
  }

  void read_feature(const Json& feature, const std::string& place) {
    const std::string type = type_of(feature, place);
    if (type != "Feature") fail(place, fmt::format("expected a Feature, found '{}'", printable(type)));
    const auto geometry = feature.find("geometry");
    if (geometry == feature.end()) fail(place, "expected a 'geometry'");
    if (geometry->is_null()) return;  // a feature without a place, which RFC 7946 allows
    const std::string inside = within(place, "geometry");
    read_geometry(*geometry, type_of(*geometry, inside), inside, 1);
  }

  void read_geometry(const Json& geometry, const std::string& type, const std::string& place, int depth) {
    if (type == "GeometryCollection") {
      if (depth > kDeepestCollection)
        fail(place, fmt::format("expected at most {} collections in each other", kDeepestCollection));
      std::size_t k = 0;
      for (const Json& member : list_in(geometry, "geometries", place)) {
        const std::string inside = within(place, fmt::format("geometries[{}]", k++));
        read_geometry(member, type_of(member, inside), inside, depth + 1);
      }
      return;
    }
    const int levels = type == "LineString" ? 0 : type == "MultiLineString" || type == "Polygon" ? 1 : 2;
    const bool closed = type == "Polygon" || type == "MultiPolygon";
    if (type != "LineString" && type != "MultiLineString" && !closed) refuse_type(type, place);
    read_lines(list_in(geometry, "coordinates", place), levels, closed, within(place, "coordinates"));
  }

  [[noreturn]] void refuse_type(const std::string& type, const std::string& place) const {
    const std::string_view nearest = nearest_name(type, kTypes);
    const std::string expected =
        "expected LineString, MultiLineString, Polygon, MultiPolygon or "
        "GeometryCollection";
    const std::string found = fmt::format(", found '{}'", printable(type));
    const bool known = std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end();
    fail(place, expected + found + (known ? "" : fmt::format("; the nearest type is '{}'", nearest)));
  }

  /// Lists of lists of points, `levels` deep.
  void read_lines(const Json& list, int levels, bool closed, const std::string& place) {
    if (!list.is_array()) fail(place, "expected a list");
    if (levels == 0) {
      std::vector<MapPoint> points;
      points.reserve(list.size());
      for (std::size_t k = 0; k < list.size(); ++k) points.push_back(point_of(list[k], place, k));
      return guarded(place,
                     [&] { closed ? walls_.add_polygon(std::move(points)) : walls_.add_polyline(points); });
    }
    std::size_t k = 0;
    for (const Json& part : list) read_lines(part, levels - 1, closed, fmt::format("{}[{}]", place, k++));
  }

  MapPoint point_of(const Json& point, const std::string& place, std::size_t k) const {
    const bool fits = point.is_array() && point.size() >= 2 && point[0].is_number() && point[1].is_number();
    if (!fits) fail(fmt::format("{}[{}]", place, k), "expected a point [x, y] in metres");
    try {
      return {WallCollector::checked(point[0].get<double>()), WallCollector::checked(point[1].get<double>())};
    } catch (const BrokenWall& broken) {
      fail(fmt::format("{}[{}]", place, k), broken.why);
    }
  }

  const std::string& file_;
  SegmentMap map_;
  WallCollector walls_;
};

Json document_of(const std::string& text, const std::string& name) {
  const std::size_t start = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;  // a byte order mark
  try {
    return Json::parse(text.begin() + static_cast<std::ptrdiff_t>(start), text.end());
  } catch (const Json::parse_error& e) {
    throw input_error(name, line_of(text, start + std::max<std::size_t>(e.byte, 1) - 1), "not valid JSON");
  } catch (const Json::exception& e) {
    throw input_error(name, 0, "not valid JSON: a number is too large");
  }
}

}  // namespace

SegmentMap segment_map_from_geojson(const std::string& text, const std::string& name) {
  if (text.size() > kLongestSegmentFile) {
    throw input_error(
        name, 0,
        fmt::format("expected a segment map of at most {} MiB", kLongestSegmentFile / (1024 * 1024)));
  }
  return GeojsonWalk(name).walk(document_of(text, name));
}

}  // namespace parloc
