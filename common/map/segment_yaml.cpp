// GridWall maps in YAML: lists of segments, polylines and polygons.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/file/text_fields.h"
#include "common/file/yaml_section.h"
#include "common/map/map_limits.h"
#include "common/map/segment_map.h"
#include "common/map/wall_collector.h"

namespace parloc {
namespace {

constexpr std::array<std::string_view, 5> kSegmentKeys = {"name", "resolution", "segments", "polylines",
                                                          "polygons"};
/// The keys of a map_server YAML that a segment map does not have too.
constexpr std::array<std::string_view, 6> kImageKeys = {"image", "origin",          "negate",
                                                        "mode",  "occupied_thresh", "free_thresh"};

/// Turns the events of a YAML text into walls as they come, so that memory grows with the walls only, every
/// message has its line, and nothing can nest deeper than a polygon does.
class SegmentEvents : public YamlEvents {
 public:
  explicit SegmentEvents(const std::string& file) : file_(file) {}

  SegmentMap take() {
    return guarded(0, [&] {
      map_.lines = walls_.take();
      return std::move(map_);
    });
  }

  void key(const std::string& name, std::size_t line) override {
    if (std::find(kSegmentKeys.begin(), kSegmentKeys.end(), name) == kSegmentKeys.end())
      fail(line, unknown_key_message(name, nearest_name(name, kSegmentKeys)));
    key_ = name;
    items_ = 0;
  }
  void value(YamlKind kind, const std::string& text, std::size_t line) override {
    if (kind == YamlKind::group) {
      if (in_map_) fail(line, expected_here() + ", found a group, or a '[' that is not closed");
      in_map_ = true;
    } else if (kind == YamlKind::list) {
      begin_list(line);
    } else {
      add_text(kind, text, line);
    }
  }
  void end() override {
    if (depth_ == 0) return;  // of the map
    if (depth_ == deepest()) end_numbers();
    if (depth_ == 2) end_item();
    --depth_;
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    throw input_error(file_, line, message);
  }
  template <class Work>
  auto guarded(std::size_t line, Work&& work) -> decltype(work()) {
    try {
      return work();
    } catch (const BrokenWall& broken) {
      fail(line, line == 0 ? broken.why : fmt::format("{}: {}", place(), broken.why));
    }
  }
  bool is_list_key() const { return key_ == "segments" || key_ == "polylines" || key_ == "polygons"; }
  /// How many lists stand inside each other under the key.
  int deepest() const { return key_ == "segments" ? 2 : is_list_key() ? 3 : 0; }
  std::size_t numbers_expected() const { return key_ == "segments" ? 4 : 2; }
  std::string place() const { return fmt::format("{}[{}]", key_, items_); }

  std::string expected_here() const {
    if (!in_map_) return "expected lines of 'key: value'";
    if (key_ == "segments") return "segments: expected a list of [ax, ay, bx, by] in metres";
    if (is_list_key()) return fmt::format("{}: expected a list of lists of points [x, y] in metres", key_);
    return fmt::format("{}: expected a single value", key_);
  }

  void begin_list(std::size_t line) {
    if (!in_map_ || depth_ == deepest()) fail(line, expected_here() + ", found a list");
    ++depth_;
    if (depth_ == 2) item_line_ = line, points_.clear();
    if (depth_ == deepest()) numbers_ = 0;
  }

  void add_text(YamlKind kind, const std::string& text, std::size_t line) {
    if (!in_map_ || (is_list_key() && depth_ != deepest()))
      fail(line, fmt::format("{}, found {}", expected_here(), described(kind, text)));
    if (is_list_key()) return add_number(line, text);
    if (key_ == "name") map_.name = text;
    if (key_ == "resolution") {
      const std::string wrong =
          read_number(kind, text, map_.resolution_m, kFinestResolution_m, kCoarsestResolution_m);
      if (!wrong.empty()) fail(line, key_ + wrong);
    }
  }

  void add_number(std::size_t line, const std::string& text) {
    number_line_ = line;
    double value_m = 0.0;
    if (parse_number(text, value_m) != std::errc{})
      fail(line, fmt::format("{}: expected a number, found '{}'", place(), printable(text)));
    guarded(line, [&] { WallCollector::checked(value_m); });
    if (numbers_ < numbers_expected()) values_[numbers_] = value_m;
    ++numbers_;
  }

  /// At the end of an innermost list: a segment, or a point.
  void end_numbers() {
    if (numbers_ != numbers_expected()) {
      fail(numbers_ > 0 ? number_line_ : item_line_,
           fmt::format("{}: expected {} numbers {}, found {}", place(), numbers_expected(),
                       key_ == "segments" ? "[ax, ay, bx, by]" : "[x, y]", numbers_));
    }
    points_.push_back({values_[0], values_[1]});
    if (key_ == "segments") points_.push_back({values_[2], values_[3]});
  }

  void end_item() {
    guarded(item_line_,
            [&] { key_ == "polygons" ? walls_.add_polygon(points_) : walls_.add_polyline(points_); });
    ++items_;
  }

  const std::string& file_;
  SegmentMap map_;
  WallCollector walls_;
  std::string key_;  ///< Whose value is being read.
  std::size_t items_ = 0;
  std::size_t item_line_ = 0, number_line_ = 0;
  std::vector<MapPoint> points_;
  std::array<double, 4> values_{};
  std::size_t numbers_ = 0;
  int depth_ = 0;
  bool in_map_ = false;
};

/// Stops at the first key that only one kind of map has. Without one it is the kind that the first other key
/// is nearest to.
struct KindOfMap : YamlEvents {
  struct Found {
    bool segments;
  };

  void key(const std::string& name, std::size_t) override {
    if (depth > 1 || name == "name" || name == "resolution") return;
    const auto is_one_of = [&](const auto& names) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    if (is_one_of(kSegmentKeys) || is_one_of(kImageKeys)) throw Found{is_one_of(kSegmentKeys)};
    const auto distance_to = [&](const auto& names) {
      return edit_distance(name.substr(0, 100), nearest_name(name, names));
    };
    if (!guess) guess = distance_to(kSegmentKeys) < distance_to(kImageKeys);
  }
  void value(YamlKind kind, const std::string&, std::size_t) override {
    if (kind == YamlKind::list || kind == YamlKind::group) ++depth;
  }
  void end() override { --depth; }

  int depth = 0;
  std::optional<bool> guess;
};

}  // namespace

bool is_segment_yaml(const std::string& text) {
  KindOfMap kind;
  try {
    read_yaml(text, "", {"a map", static_cast<std::size_t>(-1), ErrorKind::input, true}, kind);
  } catch (const KindOfMap::Found& found) {
    return found.segments;
  } catch (const Error&) {
  }
  return kind.guess.value_or(false);
}

SegmentMap segment_map_from_yaml(const std::string& text, const std::string& name) {
  SegmentEvents events(name);
  read_yaml(text, name, {"a segment map", kLongestSegmentFile, ErrorKind::input, true}, events);
  return events.take();
}

}  // namespace parloc
