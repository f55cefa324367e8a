#include "common/map/map_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/file/yaml_boolean.h"
#include "common/file/yaml_section.h"
#include "common/map/map_limits.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kFarthestOrigin_m = 1e8;  // farther than any map projection reaches

constexpr std::array<std::string_view, 6> kRequired{"image",  "resolution",      "origin",
                                                    "negate", "occupied_thresh", "free_thresh"};
constexpr std::pair<const char*, MapMode> kModes[]{
    {"trinary", MapMode::trinary}, {"scale", MapMode::scale}, {"raw", MapMode::raw}};

/// The bytes behind "BM" are a size, then zeros: no YAML.
bool is_bmp(const std::string& text) {
  return text.compare(0, 2, "BM") == 0 && text.find('\0') < 14;
}

void refuse_images(const std::string& text, const std::string& name) {
  const auto starts_with = [&](std::string_view magic) { return text.compare(0, magic.size(), magic) == 0; };
  if (starts_with("P5") || starts_with("P2") || starts_with("\x89PNG") || is_bmp(text))
    throw input_error(name, 0, "is an image: expected the map's YAML file, which names the image");
}

Pose origin_of(const YamlSection& top, const std::string& name, std::vector<std::string>& notes) {
  double origin[3] = {};
  top.numbers("origin", origin, 3, -kFarthestOrigin_m, kFarthestOrigin_m,
              "[x, y, yaw] in metres and radians");
  const double yaw_rad = wrap64(origin[2]);
  if (std::fabs(origin[2]) > 2.0 * kPi)
    notes.push_back(fmt::format("{}:{}: origin: a yaw of {} rad is more than a turn: taken as {:.6g} rad",
                                name, top.line("origin"), origin[2], yaw_rad));
  return {origin[0], origin[1], yaw_rad};
}

bool negate_of(const YamlSection& top) {
  const YamlScalar scalar = top.scalar("negate");
  if (scalar.is_one && (scalar.text == "0" || scalar.text == "1")) return scalar.text == "1";
  if (const auto value = yaml_boolean(scalar.text); value && scalar.is_one) return *value;
  throw top.error_at(scalar.line, "negate: expected 0, 1, false or true, got " + scalar.described);
}

/// How many letters are wrong: one too many, missing, other, or two that changed places.
std::size_t letters_wrong(std::string_view written, std::string_view known) {
  const std::size_t distance = edit_distance(written, known);
  if (written.size() != known.size() || distance != 2) return distance;
  const auto [a, b] = std::mismatch(written.begin(), written.end(), known.begin());
  const bool swapped = a + 1 != written.end() && a[0] == b[1] && a[1] == b[0];
  return swapped ? 1 : distance;
}

/// Whether a key that nobody knows was meant to be `known`: then the file does not mean what its writer
/// thinks. The more that speaks against another purpose of its own (the known key is missing, or long), the
/// more letters may be wrong.
bool stands_for(const YamlSection& top, const std::string& key, std::string_view known) {
  const std::size_t wrong = letters_wrong(lower_case(key), known);
  const bool is_there = top.line(std::string(known)) > 0;
  if (known == "mode") {  // may be missing: its value tells
    const auto is_value = [&](const auto& mode) { return top.scalar(key).text == mode.first; };
    return !is_there && wrong <= 2 && std::any_of(std::begin(kModes), std::end(kModes), is_value);
  }
  return is_there ? wrong <= 1 && known.size() >= 10 : wrong <= std::max<std::size_t>(2, known.size() / 3);
}

/// Keys of the outermost group that are none of ours: an error if one stands for ours, else a note.
void note_other_keys(const YamlSection& top, const std::string& name, std::vector<std::string>& notes) {
  for (const std::string& key : top.keys()) {
    if (key == "mode" || std::find(kRequired.begin(), kRequired.end(), key) != kRequired.end()) continue;
    const std::size_t line = top.line(key);
    if (key == "<<") throw top.error_at(line, unknown_key_message(key, "mode"));  // YAML's merging of groups
    const std::string start = key.substr(0, 100);  // bounds the work of a hostile key
    for (const std::string_view known : kRequired)
      if (stands_for(top, start, known)) throw top.error_at(line, unknown_key_message(key, known));
    if (stands_for(top, start, "mode")) throw top.error_at(line, unknown_key_message(key, "mode"));
    notes.push_back(fmt::format("{}:{}: the key '{}' is not used", name, line, printable(key)));
  }
}

}  // namespace

MapYaml map_yaml_from_text(const std::string& text, const std::string& name) {
  refuse_images(text, name);
  const YamlSection top(text, name, {"a map YAML", kLongestMapYaml, ErrorKind::input, true});
  MapYaml yaml;
  note_other_keys(top, name, yaml.notes);
  for (const std::string_view key : kRequired)
    if (!top.has(std::string(key))) throw top.error(std::string(key), "is missing");
  top.text("image", yaml.image);
  yaml.image_line = top.line("image");
  top.number("resolution", yaml.resolution_m, kFinestResolution_m, kCoarsestResolution_m);
  yaml.T_map_grid = origin_of(top, name, yaml.notes);
  yaml.negate = negate_of(top);
  top.number("occupied_thresh", yaml.occupied_thresh, 0.0, 1.0);
  top.number("free_thresh", yaml.free_thresh, 0.0, 1.0);
  top.choice("mode", yaml.mode, kModes);
  if (yaml.free_thresh > yaml.occupied_thresh)
    throw top.error("free_thresh", fmt::format("{} must not be above occupied_thresh {}", yaml.free_thresh,
                                               yaml.occupied_thresh));
  return yaml;
}

}  // namespace parloc
