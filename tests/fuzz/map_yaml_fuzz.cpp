// Any text is a map YAML whose values are within their ranges, or an Error{input} of one line.
#include <cmath>

#include "common/map/map_yaml.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::reads_or_says_why(parloc::ErrorKind::input, [&] {
    const parloc::MapYaml yaml = parloc::map_yaml_from_text(parloc::fuzz::text_of(data, size), "fuzz");
    parloc::fuzz::require(yaml.resolution_m > 0.0 && std::isfinite(yaml.resolution_m) &&
                          !yaml.image.empty() && std::fabs(yaml.T_map_grid.theta_rad) < 3.15 &&
                          std::isfinite(yaml.T_map_grid.x_m) && std::isfinite(yaml.T_map_grid.y_m) &&
                          yaml.free_thresh <= yaml.occupied_thresh);
  });
  return 0;
}
