#include "common/config/pose_filters.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "common/flow/flow_filter.h"

namespace parloc {
namespace {

class ParticlePoseFilter final : public PoseFilter {
 public:
  ParticlePoseFilter(const FilterConfig& config, const GridMap& map) : filter_(config, map) {}

  void start_at(const Pose& pose, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) override {
    filter_.start_at(pose, sigma_x_m, sigma_y_m, sigma_theta_rad);
  }
  void set_seed(std::uint64_t seed) override { filter_.set_seed(seed); }
  void add_odometry(double stamp_s, const Pose& odometry) override {
    filter_.add_odometry(stamp_s, odometry);
  }
  Estimate step(const Pose& odometry, const Scan& scan) override {
    const std::size_t before = filter_.steps();
    const Estimate e = filter_.step(odometry, scan);
    why_ = e.weighted                  ? ""
           : filter_.steps() == before ? "too little motion, or odometry not finite"
                                       : "too few beams";
    return e;
  }
  std::string why_skipped() const override { return why_; }
  BeamCounts beam_counts() const override { return filter_.beam_counts(); }
  std::size_t steps() const override { return filter_.steps(); }
  std::string backend_name() const override { return filter_.backend_name(); }
  std::string digest() const override { return filter_.digest(); }

 private:
  ParticleFilter filter_;
  std::string why_;
};

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
    return std::make_unique<ParticlePoseFilter>(c, map);
  }
  if (name == "amcl") {
    if (!c.adapts_particles()) c.min_particles = 500, c.max_particles = 3000;
    return std::make_unique<ParticlePoseFilter>(c, map);
  }
  for (const auto& [known, method] : kFlowNames)
    if (name == known) return std::make_unique<FlowFilter>(method, flow_filter_config(config), map);
  throw Error(ErrorKind::config, "filter '" + std::string(name) + "': expected one of " + all_names());
}

}  // namespace parloc
