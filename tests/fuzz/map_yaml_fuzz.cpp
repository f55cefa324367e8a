// Any text is a map YAML whose values are within their ranges, or an Error{input} of one line.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/error.h"
#include "common/map/map_yaml.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const parloc::MapYaml yaml = parloc::map_yaml_from_text(text, "fuzz");
    const bool sane = yaml.resolution_m > 0.0 && std::isfinite(yaml.resolution_m) && !yaml.image.empty() &&
                      std::fabs(yaml.T_map_grid.theta_rad) < 3.15 && std::isfinite(yaml.T_map_grid.x_m) &&
                      std::isfinite(yaml.T_map_grid.y_m) && yaml.free_thresh < yaml.occupied_thresh;
    if (!sane) std::abort();
  } catch (const parloc::Error& e) {
    if (e.kind() != parloc::ErrorKind::input) std::abort();
    if (std::string(e.what()).find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
