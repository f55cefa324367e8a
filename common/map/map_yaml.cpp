#include "common/map/map_yaml.h"

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
#include <system_error>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/map/map_limits.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr std::array<std::string_view, 7> kKeys = {"image",           "resolution",  "origin", "negate",
                                                   "occupied_thresh", "free_thresh", "mode"};
constexpr double kFarthestOrigin_m = 1e8;  // farther than any map projection reaches

std::size_t line_of(const YAML::Mark& mark) {
  return mark.line < 0 ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

/// Text from a file, fit for one line of a message.
std::string printable(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out(text.substr(0, longest));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  return text.size() > longest ? out + "..." : out;
}

void refuse_other_files(const std::string& text, const std::string& name) {
  const auto starts_with = [&](std::string_view magic) { return text.compare(0, magic.size(), magic) == 0; };
  if (starts_with("P5") || starts_with("P2") || starts_with("\x89PNG")) {
    throw input_error(name, 0, "is an image: expected the map's YAML file, which names the image");
  }
  if (text.size() > kLongestMapYaml) {
    throw input_error(name, 0, fmt::format("expected a map YAML of at most {} KiB", kLongestMapYaml / 1024));
  }
}

/// One line of a map YAML: a key with a text, or with a list of texts.
struct Entry {
  std::string key;
  std::size_t line;
  std::vector<std::string> values;
  bool is_list = false;
};

/// YAML events -> entries; throws Error{input} at the first thing that a map YAML cannot hold. Events rather
/// than a node tree: every entry has its line, nothing nests, and a second document (which yaml-cpp 0.7 finds
/// without end in a lone comma) stops the parser.
class EntryCollector : public YAML::EventHandler {
 public:
  explicit EntryCollector(const std::string& name) : name_(name) {}
  std::vector<Entry> entries;

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(mark, "expected one YAML document, found a second one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add_text(mark, ""); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(mark, "aliases ('*name') are not allowed");
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& value) override {
    add_text(mark, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    if (level_ != Level::value) fail(mark, level_ == Level::key ? kExpectedKey : kExpectedLines);
    entries.back().is_list = true;
    level_ = Level::list;
  }
  void OnSequenceEnd() override { level_ = Level::key; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    if (level_ != Level::document) fail(mark, level_ == Level::key ? kExpectedKey : kExpectedLines);
    level_ = Level::key;
  }
  void OnMapEnd() override { level_ = Level::document; }

 private:
  enum class Level { document, key, value, list };
  static constexpr const char* kExpectedKey = "expected a key, found a list or a group";
  static constexpr const char* kExpectedLines = "expected lines of 'key: value'";

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& message) const {
    throw input_error(name_, line_of(mark), message);
  }
  void add_text(const YAML::Mark& mark, const std::string& text) {
    switch (level_) {
      case Level::document:
        fail(mark, kExpectedLines);
      case Level::key:
        add_key(mark, text);
        level_ = Level::value;
        break;
      case Level::value:
        level_ = Level::key;
        [[fallthrough]];
      case Level::list:
        entries.back().values.push_back(text);
    }
  }
  void add_key(const YAML::Mark& mark, const std::string& key) {
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end()) {
      fail(mark, fmt::format("unknown key '{}'; the nearest valid key is '{}'", printable(key),
                             nearest_name(key, kKeys)));
    }
    for (const Entry& earlier : entries) {
      if (earlier.key == key)
        fail(mark, fmt::format("duplicate key '{}', first on line {}", key, earlier.line));
    }
    entries.push_back({key, line_of(mark), {}, false});
  }

  const std::string& name_;
  Level level_ = Level::document;
  int documents_ = 0;
};

std::vector<Entry> entries_of(const std::string& text, const std::string& name) {
  refuse_other_files(text, name);
  EntryCollector collector(name);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(collector)) {
    }
  } catch (const YAML::Exception& e) {
    throw input_error(name, line_of(e.mark), "not valid YAML: " + printable(e.msg));
  }
  return std::move(collector.entries);
}

/// The entries of one map YAML file as values of the right type and range.
class MapDocument {
 public:
  MapDocument(const std::string& text, const std::string& name)
      : name_(name), entries_(entries_of(text, name)) {}

  std::size_t line(const char* key) const { return entry(key).line; }
  std::string text(const char* key) const;
  double number(const char* key, double low, double high) const;
  bool flag(const char* key) const;
  MapMode mode() const;
  Pose origin() const;
  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    throw input_error(name_, line, message);
  }

 private:
  const Entry* find(const char* key) const;
  const Entry& entry(const char* key) const;
  double number_of(const std::string& text, const Entry& where, double low, double high) const;

  std::string name_;
  std::vector<Entry> entries_;
};

const Entry* MapDocument::find(const char* key) const {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  return found == entries_.end() ? nullptr : &*found;
}

const Entry& MapDocument::entry(const char* key) const {
  const Entry* found = find(key);
  if (found == nullptr) fail(0, fmt::format("missing key '{}'", key));
  return *found;
}

std::string MapDocument::text(const char* key) const {
  const Entry& e = entry(key);
  if (e.is_list) fail(e.line, fmt::format("{}: expected a single value, got a list", key));
  if (e.values[0].empty()) fail(e.line, fmt::format("{}: expected a value, got nothing", key));
  return e.values[0];
}

// Locale-independent; the whole text must be the number.
double MapDocument::number_of(const std::string& text, const Entry& where, double low, double high) const {
  std::string_view digits = text;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-')
    digits.remove_prefix(1);  // from_chars knows no '+'
  double value = 0.0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || status == std::errc::invalid_argument) {
    fail(where.line, fmt::format("{}: expected a number, got '{}'", where.key, printable(text)));
  }
  if (status != std::errc() || !(value >= low && value <= high)) {  // also NaN
    fail(where.line, fmt::format("{} must be {:g} to {:g}, got {}", where.key, low, high, printable(text)));
  }
  return value;
}

double MapDocument::number(const char* key, double low, double high) const {
  return number_of(text(key), entry(key), low, high);
}

bool MapDocument::flag(const char* key) const {
  const std::string written = text(key);
  const bool yes = written == "1" || written == "true";
  if (!yes && written != "0" && written != "false") {
    fail(line(key), fmt::format("{}: expected 0, 1, false or true, got '{}'", key, printable(written)));
  }
  return yes;
}

MapMode MapDocument::mode() const {
  if (find("mode") == nullptr) return MapMode::trinary;
  const std::string written = text("mode");
  if (written == "trinary") return MapMode::trinary;
  if (written == "scale") return MapMode::scale;
  if (written == "raw") return MapMode::raw;
  fail(line("mode"), fmt::format("mode: expected trinary, scale or raw, got '{}'", printable(written)));
}

Pose MapDocument::origin() const {
  const Entry& e = entry("origin");
  if (!e.is_list || e.values.size() != 3) fail(e.line, "origin: expected [x, y, yaw] in metres and radians");
  const double x_m = number_of(e.values[0], e, -kFarthestOrigin_m, kFarthestOrigin_m);
  const double y_m = number_of(e.values[1], e, -kFarthestOrigin_m, kFarthestOrigin_m);
  const double yaw_rad = number_of(e.values[2], e, -kFarthestOrigin_m, kFarthestOrigin_m);
  if (std::fabs(yaw_rad) > 2.0 * kPi) {
    fail(e.line, fmt::format("origin: expected a yaw in radians, at most one turn, got {}", yaw_rad));
  }
  return {x_m, y_m, wrap64(yaw_rad)};
}

}  // namespace

MapYaml map_yaml_from_text(const std::string& text, const std::string& name) {
  const MapDocument document(text, name);
  MapYaml yaml;
  yaml.image = document.text("image");
  yaml.image_line = document.line("image");
  yaml.resolution_m = document.number("resolution", kFinestResolution_m, kCoarsestResolution_m);
  yaml.T_map_grid = document.origin();
  yaml.negate = document.flag("negate");
  yaml.occupied_thresh = document.number("occupied_thresh", 0.0, 1.0);
  yaml.free_thresh = document.number("free_thresh", 0.0, 1.0);
  yaml.mode = document.mode();
  if (!(yaml.free_thresh < yaml.occupied_thresh)) {
    document.fail(document.line("free_thresh"), fmt::format("free_thresh {} must be below occupied_thresh {}",
                                                            yaml.free_thresh, yaml.occupied_thresh));
  }
  return yaml;
}

}  // namespace parloc
