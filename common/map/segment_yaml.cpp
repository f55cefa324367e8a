// Segment maps in YAML: lists of segments, polylines and polygons.
#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/file/text_fields.h"
#include "common/map/map_limits.h"
#include "common/map/segment_keys.h"
#include "common/map/segment_map.h"
#include "common/map/wall_collector.h"

namespace parloc {
namespace {

std::size_t line_of(const YAML::Mark& mark) {
  return mark.line < 0 ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

/// Turns the events of a YAML text into walls as they come, so that memory grows with the walls only, every
/// message has its line, and nothing can nest deeper than a polygon does.
class SegmentEvents : public YAML::EventHandler {
 public:
  explicit SegmentEvents(const std::string& file) : file_(file) {}

  SegmentMap take() {
    return guarded(0, [&] {
      map_.lines = walls_.take();
      return std::move(map_);
    });
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(line_of(mark), "expected one YAML document, found a second one");
  }
  void OnDocumentEnd() override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(line_of(mark), "aliases ('*name') are not allowed");
  }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add_text(line_of(mark), ""); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& value) override {
    add_text(line_of(mark), value);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    if (in_map_ || depth_ > 0)
      fail(line_of(mark), expected_here() + ", found a group, or a '[' that is not closed");
    in_map_ = true;
  }
  void OnMapEnd() override {}
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    if (key_.empty() || depth_ == deepest()) fail(line_of(mark), expected_here() + ", found a list");
    ++depth_;
    if (depth_ == 2) item_line_ = line_of(mark), points_.clear();
    if (depth_ == deepest()) numbers_ = 0;
  }
  void OnSequenceEnd() override {
    if (depth_ == deepest()) end_numbers();
    if (depth_ == 2) end_item();
    if (--depth_ == 0) key_.clear();
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
      fail(line, key_.empty() ? broken.why : fmt::format("{}: {}", place(), broken.why));
    }
  }
  bool is_list_key() const { return key_ == "segments" || key_ == "polylines" || key_ == "polygons"; }
  /// How many lists stand inside each other under the key.
  int deepest() const { return key_ == "segments" ? 2 : is_list_key() ? 3 : 0; }
  std::size_t numbers_expected() const { return key_ == "segments" ? 4 : 2; }
  std::string place() const { return fmt::format("{}[{}]", key_, items_); }

  std::string expected_here() const {
    if (!in_map_) return "expected lines of 'key: value'";
    if (key_.empty()) return "expected a key";
    if (key_ == "segments") return "segments: expected a list of [ax, ay, bx, by] in metres";
    if (is_list_key()) return fmt::format("{}: expected a list of lists of points [x, y] in metres", key_);
    return fmt::format("{}: expected a single value", key_);
  }

  void add_text(std::size_t line, const std::string& text) {
    if (!in_map_) fail(line, expected_here());
    if (key_.empty()) return begin_key(line, text);
    if (is_list_key()) {
      if (depth_ != deepest()) fail(line, fmt::format("{}, found '{}'", expected_here(), printable(text)));
      return add_number(line, text);
    }
    if (key_ == "name") map_.name = text;
    if (key_ == "resolution") map_.resolution_m = resolution_of(line, text);
    key_.clear();
  }

  void begin_key(std::size_t line, const std::string& key) {
    if (std::find(kSegmentKeys.begin(), kSegmentKeys.end(), key) == kSegmentKeys.end()) {
      fail(line, fmt::format("unknown key '{}'; the nearest valid key is '{}'", printable(key),
                             nearest_name(key, kSegmentKeys)));
    }
    for (const auto& [earlier, earlier_line] : seen_) {
      if (earlier == key) fail(line, fmt::format("duplicate key '{}', first on line {}", key, earlier_line));
    }
    seen_.emplace_back(key, line);
    key_ = key;
    items_ = 0;
  }

  double number_of(std::size_t line, const std::string& text) const {
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-')
      digits.remove_prefix(1);  // from_chars knows no '+'
    double value = 0.0;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (status != std::errc() || end != digits.data() + digits.size()) {
      fail(line,
           fmt::format("{}: expected a number, found '{}'", is_list_key() ? place() : key_, printable(text)));
    }
    return value;
  }

  double resolution_of(std::size_t line, const std::string& text) const {
    const double value_m = number_of(line, text);
    if (!(value_m >= kFinestResolution_m && value_m <= kCoarsestResolution_m)) {
      fail(line, fmt::format("resolution must be {:g} to {:g}, got {}", kFinestResolution_m,
                             kCoarsestResolution_m, printable(text)));
    }
    return value_m;
  }

  void add_number(std::size_t line, const std::string& text) {
    number_line_ = line;
    const double value_m = number_of(line, text);
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
  std::vector<std::pair<std::string, std::size_t>> seen_;
  std::string key_;  ///< Whose value is being read; empty between values.
  std::size_t items_ = 0;
  std::size_t item_line_ = 0, number_line_ = 0;
  std::vector<MapPoint> points_;
  std::array<double, 4> values_{};
  std::size_t numbers_ = 0;
  int depth_ = 0;
  bool in_map_ = false;
  int documents_ = 0;
};

}  // namespace

SegmentMap segment_map_from_yaml(const std::string& text, const std::string& name) {
  if (text.size() > kLongestSegmentFile) {
    throw input_error(
        name, 0,
        fmt::format("expected a segment map of at most {} MiB", kLongestSegmentFile / (1024 * 1024)));
  }
  SegmentEvents events(name);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(events)) {
    }
  } catch (const YAML::Exception& e) {
    throw input_error(name, line_of(e.mark), "not valid YAML: " + printable(e.msg));
  }
  return events.take();
}

}  // namespace parloc
