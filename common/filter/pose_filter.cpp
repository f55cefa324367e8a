#include "common/filter/pose_filter.h"

#include <utility>

#include "common/filter/filter_run.h"
#include "common/filter/map_frame.h"

namespace parloc {

void PoseFilter::Run::begin() {
  front_end.clear();
  last = {};
  steps = 0;
  estimates = {};
  started = true;
}

void PoseFilter::Run::remember(const Estimate& e) {
  for (const double v : {e.pose.x_m, e.pose.y_m, e.pose.theta_rad, e.n_eff}) estimates.add(v);
  for (const double v : e.covariance.v) estimates.add(v);
  last = e;
  ++steps;
}

Estimate PoseFilter::Run::not_weighed() const {
  Estimate e = last;
  e.weighted = e.resampled = e.lost = false;
  return e;
}

PoseFilter::PoseFilter(std::unique_ptr<Run> run) : run_(std::move(run)) {}
PoseFilter::~PoseFilter() = default;
PoseFilter::PoseFilter(PoseFilter&&) noexcept = default;
PoseFilter& PoseFilter::operator=(PoseFilter&&) noexcept = default;

void PoseFilter::set_seed(std::uint64_t seed) {
  run_->settings.seed = seed;
}
void PoseFilter::add_odometry(double stamp_s, const Pose& odometry) {
  run_->front_end.add_odometry(stamp_s, odometry);
}
std::optional<OdometryReading> PoseFilter::prepare_odometry(double stamp_s, const Pose& odometry) {
  return run_->front_end.prepare_odometry(stamp_s, odometry);
}
const std::string& PoseFilter::why_skipped() const {
  return run_->why_skipped;
}
std::vector<Particle> PoseFilter::particles(std::size_t most) const {
  return in_map_frame(run_->download(), run_->map.T_map_grid, most);
}
BeamCounts PoseFilter::beam_counts() const {
  return run_->front_end.beam_counts();
}
const std::vector<LidarUse>& PoseFilter::lidars_used() const {
  return run_->front_end.lidars_used();
}
std::size_t PoseFilter::odometry_jumps() const {
  return run_->front_end.continuous().jumps();
}
std::size_t PoseFilter::odometry_invalid() const {
  return run_->front_end.continuous().invalid();
}
std::size_t PoseFilter::steps() const {
  return run_->steps;
}
std::string PoseFilter::backend_name() const {
  return run_->backend_name();
}
const GridMap& PoseFilter::map() const {
  return run_->map;
}

std::string PoseFilter::digest() const {
  const ParticleSet set = run_->download();
  Sha256 sha = run_->estimates;
  for (const auto* values : {&set.x, &set.y, &set.theta, &set.log_weight})
    for (const float v : *values) sha.add(v);
  return sha.hex();
}

}  // namespace parloc
