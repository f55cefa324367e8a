// Which kind of map a text is.
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <array>
#include <sstream>
#include <string_view>

#include "common/file/nearest_name.h"
#include "common/map/segment_keys.h"
#include "common/map/segment_map.h"

namespace parloc {
namespace {

/// The keys of a map_server YAML that a segment map does not have too.
constexpr std::array<std::string_view, 6> kImageKeys = {"image", "origin",          "negate",
                                                        "mode",  "occupied_thresh", "free_thresh"};

/// Stops at the first key that only one kind of map has, or that is nearest to one such.
class KindOfMap : public YAML::EventHandler {
 public:
  struct Found {
    bool segments;
  };

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override { throw Found{false}; }
  void OnNull(const YAML::Mark&, YAML::anchor_t) override { add(""); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { throw Found{false}; }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string& value) override {
    add(value);
  }
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    ++depth_;
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    ++depth_;
  }
  void OnMapEnd() override { end(); }

 private:
  void end() {
    if (--depth_ == 1) at_key_ = true;
  }
  void add(const std::string& text) {
    if (depth_ != 1) return;
    if (at_key_ && text != "name" && text != "resolution") judge(text);
    at_key_ = !at_key_;
  }
  static void judge(const std::string& key) {
    const auto distance_to = [&](const auto& names) {
      const std::string_view nearest = nearest_name(key, names);
      return edit_distance(key.substr(0, 100), nearest);
    };
    throw Found{distance_to(kSegmentKeys) < distance_to(kImageKeys)};
  }

  int depth_ = 0;
  bool at_key_ = true;
};

}  // namespace

bool is_segment_yaml(const std::string& text) {
  try {
    KindOfMap kind;
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    parser.HandleNextDocument(kind);
  } catch (const KindOfMap::Found& found) {
    return found.segments;
  } catch (const YAML::Exception&) {
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
