#include "common/config/pose_filters.h"

#include <utility>

#include "common/error.h"
#include "common/filter/particle_filter.h"
#include "common/flow/flow_filter.h"

namespace parloc {
namespace {

constexpr std::array<std::pair<std::string_view, FlowMethod>, 7> kFlowNames{
    {{"ekf", FlowMethod::ekf},
     {"ekf_beams", FlowMethod::ekf_beams},
     {"edh", FlowMethod::edh},
     {"naedh", FlowMethod::naedh},
     {"ledh", FlowMethod::ledh},
     {"gromov", FlowMethod::gromov},
     {"pfpf", FlowMethod::pfpf}}};

std::string all_names() {
  std::string names;
  for (const std::string_view name : kPoseFilterNames)
    names += (names.empty() ? "" : " ") + std::string(name);
  return names;
}

}  // namespace

std::unique_ptr<PoseFilter> make_pose_filter(std::string_view name, const Config& config,
                                             const GridMap& map) {
  FilterConfig c = config;
  if (name == "mcl") {
    c.particles = c.most_particles();
    c.min_particles = c.max_particles = 0;
    return std::make_unique<ParticleFilter>(c, map);
  }
  if (name == "amcl") {
    if (!c.adapts_particles()) c.min_particles = 500, c.max_particles = 3000;
    return std::make_unique<ParticleFilter>(c, map);
  }
  for (const auto& [known, method] : kFlowNames)
    if (name == known) return std::make_unique<FlowFilter>(method, flow_filter_config(config), map);
  throw Error(ErrorKind::config, "filter '" + std::string(name) + "': expected one of " + all_names());
}

}  // namespace parloc
