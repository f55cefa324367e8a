#include "common/map/map_yaml.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "common/error.h"
#include "common/file/yaml_section.h"
#include "common/map/map_limits.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kFarthestOrigin_m = 1e8;  // farther than any map projection reaches

void refuse_images(const std::string& text, const std::string& name) {
  const auto starts_with = [&](std::string_view magic) { return text.compare(0, magic.size(), magic) == 0; };
  if (starts_with("P5") || starts_with("P2") || starts_with("\x89PNG"))
    throw input_error(name, 0, "is an image: expected the map's YAML file, which names the image");
}

Pose origin_of(const YamlSection& top) {
  double origin[3] = {};
  top.numbers("origin", origin, 3, -kFarthestOrigin_m, kFarthestOrigin_m,
              "[x, y, yaw] in metres and radians");
  const double yaw_rad = origin[2];
  if (std::fabs(yaw_rad) > 2.0 * kPi) {
    throw top.error("origin", fmt::format("must have a yaw in radians, at most one turn, got {}", yaw_rad));
  }
  return {origin[0], origin[1], wrap64(yaw_rad)};
}

}  // namespace

MapYaml map_yaml_from_text(const std::string& text, const std::string& name) {
  refuse_images(text, name);
  const YamlSection top(text, name, {"a map YAML", kLongestMapYaml, ErrorKind::input, true});
  for (const char* key : {"image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"})
    top.require(key);
  MapYaml yaml;
  top.text("image", yaml.image);
  yaml.image_line = top.line("image");
  top.number("resolution", yaml.resolution_m, kFinestResolution_m, kCoarsestResolution_m);
  yaml.T_map_grid = origin_of(top);
  top.choice("negate", yaml.negate, {{"0", false}, {"1", true}, {"false", false}, {"true", true}});
  top.number("occupied_thresh", yaml.occupied_thresh, 0.0, 1.0);
  top.number("free_thresh", yaml.free_thresh, 0.0, 1.0);
  top.choice("mode", yaml.mode,
             {{"trinary", MapMode::trinary}, {"scale", MapMode::scale}, {"raw", MapMode::raw}});
  top.finish();
  if (!(yaml.free_thresh < yaml.occupied_thresh)) {
    throw top.error("free_thresh", fmt::format("{} must be below occupied_thresh {}", yaml.free_thresh,
                                               yaml.occupied_thresh));
  }
  return yaml;
}

}  // namespace parloc
