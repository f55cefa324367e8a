#include "common/filter/pose_filter.h"

#include <utility>

#include "common/error.h"
#include "common/filter/filter_run.h"
#include "common/filter/map_frame.h"

namespace parloc {

void PoseFilter::Run::begin() {
  front_end.clear();
  last = {};
  given = {};
  given_s.reset();
  steps = 0;
  estimates = {};
  started = true;
}

void PoseFilter::Run::expect_started() const {
  if (!started) throw Error(ErrorKind::usage, "a step before a start: call start_at or start_anywhere first");
}

std::optional<OdometryReading> PoseFilter::Run::take(const Pose& recorded, const Scan& scan) {
  expect_started();
  if (is_finite(recorded)) front_end.check(scan);  // mounts in logs may follow from odometry
  why_skipped = front_end.refuse(scan);
  if (!why_skipped.empty()) return std::nullopt;
  std::optional<OdometryReading> reading = front_end.take_odometry(scan.stamp_s, recorded);
  if (reading)
    front_end.note_taken(scan);
  else
    why_skipped = front_end.why_no_odometry();
  return reading;
}

void PoseFilter::Run::remember(const Estimate& e, const PoseEstimate& chosen) {
  for (const double v : {e.pose.x_m, e.pose.y_m, e.pose.theta_rad, e.n_eff}) estimates.add(v);
  for (const double v : e.covariance.v) estimates.add(v);
  last = e;
  given = chosen;
  given_s = e.stamp_s;
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

void PoseFilter::start_at(const Pose& pose, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) {
  check_start(run_->map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad);
  start_at(pose, covariance_of(sigma_x_m, sigma_y_m, sigma_theta_rad));
}
Estimate PoseFilter::step(const Scan& scan) {
  run_->expect_started();
  check(scan);
  if (!refuses(scan)) prepare_odometry(scan.stamp_s);
  return step(Pose{}, scan);
}
PoseEstimate PoseFilter::predict(double stamp_s) const {
  if (!run_->given_s) throw Error(ErrorKind::usage, "predict before the first step: call step first");
  return predict_from(run_->given, *run_->given_s, stamp_s);
}
PoseEstimate PoseFilter::predict_from(const PoseEstimate& from, double from_s, double to_s) const {
  return run_->front_end.predict(from, from_s, to_s);
}
void PoseFilter::check(const Scan& scan) const {
  run_->front_end.check(scan);
}
bool PoseFilter::refuses(const Scan& scan) const {
  return !run_->front_end.refusal(scan).empty();
}
void PoseFilter::set_seed(std::uint64_t seed) {
  run_->settings.seed = seed;
}
void PoseFilter::add_odometry(double stamp_s, const Pose& odometry) {
  run_->front_end.add_odometry(stamp_s, odometry);
}
std::optional<OdometryReading> PoseFilter::prepare_odometry(double stamp_s, const Pose& odometry) {
  return run_->front_end.prepare_odometry(stamp_s, odometry);
}
std::optional<OdometryReading> PoseFilter::prepare_odometry(double stamp_s) {
  return run_->front_end.prepare_odometry(stamp_s);
}
std::optional<Pose> PoseFilter::last_odometry() const {
  const std::optional<OdometryMemory>& last = run_->front_end.last_reading();
  return last ? std::optional(last->pose) : std::nullopt;
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
