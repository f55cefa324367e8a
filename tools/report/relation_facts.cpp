#include "tools/report/relation_facts.h"

#include <fmt/format.h>

#include <numbers>

namespace parloc::tools {

using Json = nlohmann::ordered_json;

Json relations_json(const std::optional<RelationErrors>& errors) {
  if (!errors) return nullptr;
  const bool known = errors->compared > 0;
  const auto value = [&](double v) { return known ? Json(v) : Json(nullptr); };
  return {{"compared", errors->compared},
          {"without_pose", errors->without_pose},
          {"translation_mean_m", value(errors->translation_mean_m)},
          {"translation_std_m", value(errors->translation_std_m)},
          {"translation_rmse_m", value(errors->translation_rmse_m)},
          {"translation_median_m", value(errors->translation_median_m)},
          {"translation_max_m", value(errors->translation_max_m)},
          {"rotation_mean_rad", value(errors->rotation_mean_rad)},
          {"rotation_std_rad", value(errors->rotation_std_rad)},
          {"rotation_rmse_rad", value(errors->rotation_rmse_rad)},
          {"rotation_median_rad", value(errors->rotation_median_rad)},
          {"rotation_max_rad", value(errors->rotation_max_rad)}};
}

std::string relations_text(const RelationErrors& e) {
  return fmt::format("{:.3f} +- {:.3f} m, {:.2f} +- {:.2f} degrees, from {}", e.translation_mean_m,
                     e.translation_std_m, e.rotation_mean_rad * (180.0 / std::numbers::pi),
                     e.rotation_std_rad * (180.0 / std::numbers::pi), e.compared);
}

}  // namespace parloc::tools
