#include "tools/run/tracker.h"
#include "common/config/config.h"

namespace parloc::tools {
namespace {

std::variant<ParticleFilter, Localizer> make_engine(const Config& config, const GridMap& map, bool judged) {
  if (judged) return Localizer(config, map);
  return ParticleFilter(config, map);
}

template <class Engine>
void start_at(Engine& engine, const StartPose& start) {
  if (start.guesses.empty()) {
    engine.start_at(start.pose, start.sigma_x_m, start.sigma_y_m, start.sigma_theta_rad);
  } else {
    engine.start_at(start.guesses);
  }
}

}  // namespace

Tracker::Tracker(const Config& config, const GridMap& map, bool judged)
    : engine_(make_engine(config, map, judged)) {}

void Tracker::start(const StartPose& start) {
  auto* localizer = std::get_if<Localizer>(&engine_);
  if (!start.anywhere) {
    std::visit([&](auto& engine) { start_at(engine, start); }, engine_);
  } else if (localizer != nullptr) {
    localizer->start_anywhere(start.prior);
  } else {
    std::get<ParticleFilter>(engine_).start_anywhere();
  }
}

void Tracker::add_odometry(double stamp_s, const Pose& odometry) {
  std::visit([&](auto& engine) { engine.add_odometry(stamp_s, odometry); }, engine_);
}

LocalizerEstimate Tracker::step(const Pose& odometry, const Scan& scan) {
  if (auto* localizer = std::get_if<Localizer>(&engine_)) return localizer->step(odometry, scan);
  LocalizerEstimate estimate;
  estimate.filter = std::get<ParticleFilter>(engine_).step(odometry, scan);
  return estimate;
}

const ParticleFilter& Tracker::filter() const {
  const auto* localizer = std::get_if<Localizer>(&engine_);
  return localizer != nullptr ? localizer->filter() : std::get<ParticleFilter>(engine_);
}

}  // namespace parloc::tools
