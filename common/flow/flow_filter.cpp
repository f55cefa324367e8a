#include "common/flow/flow_filter.h"

#include <algorithm>
#include <memory>

#include "common/error.h"
#include "common/filter/filter_run.h"
#include "common/filter/map_frame.h"
#include "common/filter/start.h"
#include "common/flow/flow_backend.h"
#include "common/flow/mean_update.h"

namespace parloc {
namespace {

constexpr double kStiff = 100.0;  // s / r from which Euler steps leave the cloud twice too wide (SPEC 7.6)

const char* text_of(FlowSkip skip) {
  switch (skip) {
    case FlowSkip::none:
      return "";
    case FlowSkip::no_scan:
      return "too few beams";
    case FlowSkip::no_slope:
      return "no beam ends near a wall of the map";
    case FlowSkip::gated:
      return "the scan is farther off than flow.gate_nis allows";
    case FlowSkip::no_update:
      break;
  }
  return "the information matrix is singular";
}

Covariance covariance_of(const Matrix3& p) {
  Covariance c;
  std::copy_n(p.m, 9, c.v);
  return c;
}

/// The start's Gaussian in the grid frame.
PoseGaussian start_gaussian(const GridMap& map, const Pose& pose, const Covariance& covariance) {
  const Pose in_grid = relative(pose, map.T_map_grid);
  const Covariance c = turned(covariance, -map.T_map_grid.theta_rad);
  PoseGaussian g;
  g.mean[0] = in_grid.x_m, g.mean[1] = in_grid.y_m, g.mean[2] = in_grid.theta_rad;
  std::copy_n(c.v, 9, g.covariance.m);
  g.covariance = proper_covariance(g.covariance);
  return g;
}

/// The filter's Gaussian, about the particles' mean if there are any.
PoseEstimate estimate_of(const FlowState& s, FlowMethod method, const Pose& T_map_grid) {
  PoseEstimate e;
  const Vector3 mean = is_kalman(method) ? s.posterior.mean : mean_of(s.cloud);
  e.mean = compose(T_map_grid, {mean[0], mean[1], mean[2]});
  e.covariance = turned(covariance_of(s.posterior.covariance), T_map_grid.theta_rad);
  e.weight = 1.0;
  e.heading_resultant = is_kalman(method) ? 1.0 : s.cloud.resultant;
  return e;
}

/// What the particles alone say.
PoseEstimate cloud_of(const FlowState& s, const Pose& T_map_grid) {
  PoseEstimate e = in_map_frame(s.cloud, T_map_grid);
  e.weight = 1.0;
  return e;
}

}  // namespace

struct FlowFilter::State : RunConfig<FlowFilterConfig>, Run {
  State(FlowMethod m, const FlowFilterConfig& c, const GridMap& on)
      : RunConfig{c}, Run(config, on), method(m) {}
  ParticleSet download() const override { return backend->download(); }
  std::string backend_name() const override { return backend->name(); }

  FlowMethod method;
  std::unique_ptr<FlowBackend> backend;
  std::size_t stiff = 0;

  std::int64_t particles() const { return is_kalman(method) ? 0 : config.particles; }
  Estimate to_estimate(const FlowState& s) const;
  bool is_stiff(const FlowState& s) const;
};

FlowFilter::State& FlowFilter::state() {
  return static_cast<State&>(*run_);
}
const FlowFilter::State& FlowFilter::state() const {
  return static_cast<const State&>(*run_);
}

Estimate FlowFilter::State::to_estimate(const FlowState& s) const {
  Estimate e;
  e.mean = estimate_of(s, method, map.T_map_grid);
  e.cluster = is_kalman(method) ? e.mean : cloud_of(s, map.T_map_grid);
  e.pose = e.mean.mean;
  e.covariance = e.mean.covariance;
  e.ambiguous_heading = e.mean.heading_resultant < 1e-3;
  e.particles = static_cast<std::size_t>(particles());
  e.n_eff = static_cast<double>(e.particles);
  e.weighted = s.skip == FlowSkip::none;
  if (method == FlowMethod::pfpf) {
    const StepState& w = backend->weights_state();
    e.n_eff = w.n_eff;
    e.resampled = w.resample != 0;
    e.lost = e.weighted && w.degenerate != 0;
  }
  return e;
}

bool FlowFilter::State::is_stiff(const FlowState& s) const {
  const bool euler = config.flow.integrator == FlowIntegrator::euler ||
                     (method == FlowMethod::edh && config.flow.integrator == FlowIntegrator::automatic);
  const bool steps_lag = !is_kalman(method) && method != FlowMethod::naedh && method != FlowMethod::gromov;
  return euler && steps_lag && s.skip == FlowSkip::none && s.stiffness > kStiff;
}

FlowFilter::FlowFilter(FlowMethod method, const FlowFilterConfig& config, const GridMap& map)
    : PoseFilter(std::make_unique<State>(method, config, map)) {
  validate(config);
  check_map(map);
  State& s = state();
  std::string why;
  s.backend = make_flow_backend(
      config.backend, {s.particles(), config.threads, config.device, config.flow, method, config.resample},
      why);
  s.backend->set_map(map);
  s.why_skipped = text_of(FlowSkip::no_scan);
}

void FlowFilter::start_at(const Pose& pose, const Covariance& covariance) {
  State& s = state();
  check_start(s.map, pose, covariance);
  s.backend->start(gaussian_start(s.map, pose, root_of(covariance), s.particles(), s.config.seed),
                   start_gaussian(s.map, pose, covariance));
  s.begin();
  s.last.pose = pose;
  s.why_skipped = text_of(FlowSkip::no_scan);
  s.stiff = 0;
}

Estimate FlowFilter::step(const Pose& recorded, const Scan& scan) {
  State& s = state();
  const std::optional<OdometryReading> odometry = s.take(recorded, scan);
  if (!odometry) return s.not_weighed();
  const FlowFilterConfig& c = s.config;
  // What the sensor models of a particle filter need of a beam is not read here.
  const bool enough = s.front_end.take(scan, SensorConfig{}, s.map.resolution_m, s.beams) &&
                      s.beams.hits >= static_cast<std::size_t>(c.scan.min_beams);
  Movement movement = s.front_end.move_to(odometry->pose);
  movement.elapsed_s = 0.0;  // flows have floors of their own
  const MotionStep motion = motion_step(movement, c.motion);
  const FlowState& after = s.backend->step(motion, s.key(), enough ? &s.beams : nullptr);
  Estimate e = s.to_estimate(after);
  e.stamp_s = scan.stamp_s;
  s.why_skipped = text_of(after.skip);
  s.stiff += s.is_stiff(after) ? 1 : 0;
  s.remember(e, e.mean);
  return e;
}

std::size_t FlowFilter::stiff_scans() const {
  return state().stiff;
}
const FlowFilterConfig& FlowFilter::config() const {
  return state().config;
}

}  // namespace parloc
