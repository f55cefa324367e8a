// Which kind of map a text is.
#include <array>
#include <string_view>

#include "common/file/nearest_name.h"
#include "common/file/yaml_reader.h"
#include "common/map/segment_keys.h"
#include "common/map/segment_map.h"

namespace parloc {
namespace {

/// The keys of a map_server YAML that a segment map does not have too.
constexpr std::array<std::string_view, 6> kImageKeys = {"image", "origin",          "negate",
                                                        "mode",  "occupied_thresh", "free_thresh"};

/// Stops at the first key that only one kind of map has, or that is nearest to one such.
struct KindOfMap : YamlEvents {
  struct Found {
    bool segments;
  };

  void key(const std::string& name, std::size_t) override {
    if (depth > 1 || name == "name" || name == "resolution") return;
    const auto distance_to = [&](const auto& names) {
      return edit_distance(name.substr(0, 100), nearest_name(name, names));
    };
    throw Found{distance_to(kSegmentKeys) < distance_to(kImageKeys)};
  }
  void value(YamlKind kind, const std::string&, std::size_t) override {
    if (kind == YamlKind::list || kind == YamlKind::group) ++depth;
  }
  void end() override { --depth; }

  int depth = 0;
};

}  // namespace

bool is_segment_yaml(const std::string& text) {
  try {
    KindOfMap kind;
    read_yaml(text, "", {"a map", static_cast<std::size_t>(-1), ErrorKind::input, true}, kind);
  } catch (const KindOfMap::Found& found) {
    return found.segments;
  } catch (const Error&) {
  }
  return false;
}

bool is_geojson(const std::string& text, const std::string& path) {
  const auto ends_with = [&](std::string_view end) {
    return path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
  };
  if (ends_with(".geojson") || ends_with(".json")) return true;
  const std::size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return start != std::string::npos && text[start] == '{' && text.find("\"type\"") != std::string::npos;
}

}  // namespace parloc
