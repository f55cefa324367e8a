#include "tools/bench/steps/rig.h"

#include "tools/bench/steps/measure.h"

namespace parloc::tools::bench {
namespace {

/// The noise of configs/paz2012.yaml.
MotionConfig motion_config() {
  MotionConfig config;
  config.alpha1 = 0.1;
  config.alpha2 = 0.05;
  config.alpha3 = 0.1;
  config.alpha4 = 0.02;
  return config;
}

}  // namespace

std::array<double, kStageNames.size()> least_stage_bytes(std::int64_t particles, int beams) {
  const double n = static_cast<double>(particles);
  const double pose = 3 * sizeof(float), log_weight = sizeof(float), weight = sizeof(std::uint64_t);
  const double cumulative = sizeof(std::uint64_t), ancestor = sizeof(std::uint32_t);
  return {n * 2 * pose,
          6.0 * sizeof(float) * beams,
          n * (pose + 2 * log_weight),
          n * (3 * log_weight + weight + cumulative),  // the maximum first, then the weights
          n * (pose + weight),
          n * (2 * (pose + log_weight) + cumulative + ancestor)};
}

Rig::Rig(const Variant& variant, const Scene& scene, Cloud cloud, std::int64_t particles)
    : scene_(&scene), cloud_(make_cloud(scene, cloud, particles)) {
  const FilterBackendConfig config = backend_config(variant, particles);
  sensor_ = config.sensor;
  resolution_m_ = scene.map.resolution_m;
  std::string why;
  backend_ = make_filter_backend(variant.backend, config, why);
  backend_->set_map(scene.map);
}

void Rig::use_beams(int beams) {
  scan_ = make_scan(*scene_, beams);
  scan_config_.max_beams = beams;
  select();
  backend_->set_range_max(beams_.range_max_m);
}

void Rig::select() {
  select_beams(scan_, scan_config_, sensor_, resolution_m_, beams_, counts_);
}

MotionStep Rig::motion() const {
  static const MotionConfig config = motion_config();
  return motion_step(odometry_increment({0.0, 0.0, 0.0}, {0.05, 0.0, 0.02}, config.min_translation_m),
                     config);
}

void Rig::restore() {
  backend_->upload(cloud_);
  backend_->finish();
  ++step_;
}

double Rig::step_seconds() {
  restore();
  const Clock::time_point begun = Clock::now();
  backend_->predict(motion(), {1, step_});
  select();
  backend_->set_scan(beams_);
  backend_->weight(true);
  backend_->normalise_scan();
  backend_->estimate();
  backend_->resample({1, step_});
  last_ = backend_->finish();
  return seconds_since(begun);
}

StageSeconds Rig::stage_seconds() {
  restore();
  StageSeconds seconds{};
  std::size_t stage = 0;
  const auto time = [&](const auto& work) {
    const Clock::time_point begun = Clock::now();
    work();
    last_ = backend_->finish();
    seconds[stage++] = seconds_since(begun);
  };
  time([&] { backend_->predict(motion(), {1, step_}); });
  time([&] {
    select();
    backend_->set_scan(beams_);
  });
  time([&] { backend_->weight(true); });
  time([&] { backend_->normalise_scan(); });
  time([&] { backend_->estimate(); });
  time([&] { backend_->resample({1, step_}); });
  return seconds;
}

}  // namespace parloc::tools::bench
