#include "common/filter/particle_filter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/filter/map_frame.h"
#include "common/filter/propose_particles.h"
#include "common/filter/run_digest.h"
#include "common/filter/start.h"
#include "common/filter/step_front_end.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kHeadingUndefined = 1e-3;  // resultant below which a circular mean means nothing (SPEC 4)

Estimate to_estimate(const StepState& s, const FilterConfig& config, const Pose& T_map_grid, bool weighted) {
  Estimate e;
  e.mean = in_map_frame(s.all, T_map_grid);
  e.cluster = in_map_frame(s.cluster, T_map_grid);
  e.ambiguous_heading = e.mean.heading_resultant < kHeadingUndefined;
  if (e.ambiguous_heading) e.mean.mean.theta_rad = e.cluster.mean.theta_rad;
  const PoseEstimate& chosen = config.estimate.mode == EstimateMode::mean ? e.mean : e.cluster;
  e.pose = chosen.mean;
  e.covariance = chosen.covariance;
  e.n_eff = s.n_eff;
  e.particles = s.count;
  e.p_injected = weighted ? s.inject : 0.0;
  e.beam_likelihood = s.likelihood.scans > 0 ? portable_exp64(s.likelihood.scan) : 0.0;
  e.weighted = weighted;
  e.resampled = weighted && s.resample != 0;
  e.lost = weighted && s.degenerate != 0;
  return e;
}

/// The last estimate, given out again: no scan was used for it.
Estimate not_weighed(const Estimate& last) {
  Estimate e = last;
  e.weighted = e.resampled = e.lost = false;
  return e;
}

/// What the filter remembers of one LiDAR.
struct LidarState {
  double range_max_m = 0.0;      ///< Of its last scan.
  std::optional<Pose> odometry;  ///< At its last processed scan.
};

}  // namespace

struct ParticleFilter::State {
  explicit State(const FilterConfig& c) : config(c), front_end(config) {}

  FilterConfig config;
  GridMap map;
  std::unique_ptr<FilterBackend> backend;
  BeamTable beams;
  StepFrontEnd front_end;
  std::vector<LidarState> lidars;  // one per LiDAR seen
  double range_max_m = 0.0;        // that the backend's tables are made for
  Estimate last;
  std::size_t steps = 0;
  int unlikely_scans = 0;  // in a row, up to the last one
  int widenings_due = 0;   // in units of the configured noise, in the next step
  bool started = false;
  RunDigest digest;

  RandomKey key() const { return {config.seed, static_cast<std::uint32_t>(steps)}; }
  void begin(ParticleSet set);
  std::size_t lidar_of(const Scan& scan);
  MotionStep motion_to(const Pose& odometry);
  bool may_widen_next() const;
  void watch_likelihood(const Estimate& e);
  bool take_in(const Scan& scan, std::size_t lidar);
  void remember(const Estimate& e);
};

void ParticleFilter::State::begin(ParticleSet set) {
  backend->upload(std::move(set));
  front_end.clear();
  lidars.clear();
  last = {};
  steps = 0;
  unlikely_scans = widenings_due = 0;
  digest = {};
  started = true;
}

std::size_t ParticleFilter::State::lidar_of(const Scan& scan) {
  const std::size_t lidar = front_end.lidar_of(scan);
  lidars.resize(front_end.intake().used().size());
  return lidar;
}

MotionStep ParticleFilter::State::motion_to(const Pose& odometry) {
  MotionStep step = motion_step(front_end.move_to(odometry), config.motion);
  const double widenings = std::exchange(widenings_due, 0);
  step.spread_xy += static_cast<float>(widenings * config.recovery.expansion_sigma_xy);
  step.spread_theta += static_cast<float>(widenings * config.recovery.expansion_sigma_theta);
  return step;
}

/// Expansion resetting (Ueda et al. 2004): after some unlikely scans in a row the cloud is widened where it
/// is, after as many more by twice as much, and so on. In between it has time to settle on the robot.
void ParticleFilter::State::watch_likelihood(const Estimate& e) {
  const RecoveryConfig& c = config.recovery;
  constexpr int kMostWidenings = 10;
  unlikely_scans = e.beam_likelihood < c.expansion_likelihood ? unlikely_scans + 1 : 0;
  if (unlikely_scans > 0 && unlikely_scans % c.expansion_scans == 0)
    widenings_due = std::min(unlikely_scans / c.expansion_scans, kMostWidenings);
}

/// If the scan of now is unlikely too.
bool ParticleFilter::State::may_widen_next() const {
  const RecoveryConfig& c = config.recovery;
  return c.expansion_likelihood > 0.0 && (unlikely_scans + 1) % c.expansion_scans == 0;
}

/// Fills `beams`; whether there are enough of them to weigh.
bool ParticleFilter::State::take_in(const Scan& scan, std::size_t lidar) {
  if (!front_end.take(scan, config.sensor, map.resolution_m, beams)) return false;

  // One table for all LiDARs, of the farthest-reaching: remaking it takes longer than a step.
  lidars[lidar].range_max_m = beams.range_max_m;
  double farthest_m = 0.0;
  for (const LidarState& l : lidars) farthest_m = std::max(farthest_m, l.range_max_m);
  if (farthest_m != range_max_m) {
    range_max_m = farthest_m;
    backend->set_range_max(range_max_m);
  }
  return true;
}

void ParticleFilter::State::remember(const Estimate& e) {
  digest.add(e);
  if (e.weighted) watch_likelihood(e);
  last = e;
}

ParticleFilter::ParticleFilter(const FilterConfig& config, const GridMap& map)
    : state_(std::make_unique<State>(config)) {
  validate(config);
  check_has_free_cell(map);
  state_->map = map;
  std::string why;
  state_->backend =
      make_filter_backend(config.backend,
                          {config.most_particles(), config.threads, config.device, config.sensor,
                           config.resample, config.fewest_particles(), config.kld, config.recovery},
                          why);
  state_->backend->set_map(map);
}

ParticleFilter::~ParticleFilter() = default;
ParticleFilter::ParticleFilter(ParticleFilter&&) noexcept = default;
ParticleFilter& ParticleFilter::operator=(ParticleFilter&&) noexcept = default;

void ParticleFilter::start_at(const Pose& pose, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) {
  State& s = *state_;
  check_start(s.map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad);
  s.begin(gaussian_start(s.map, pose, sigma_x_m, sigma_y_m, sigma_theta_rad, s.config.most_particles(),
                         s.config.seed));
}

void ParticleFilter::start_anywhere() {
  state_->begin(uniform_start(state_->map, state_->config.most_particles(), state_->config.seed));
}

namespace {

void check(const std::vector<PoseGuess>& guesses) {
  const auto usable = [](const PoseGuess& g) {
    return is_finite(g.pose) && g.sigma_xy_m >= 0 && std::isfinite(g.sigma_xy_m) && g.sigma_theta_rad >= 0 &&
           std::isfinite(g.sigma_theta_rad) && g.weight > 0 && std::isfinite(g.weight);
  };
  if (guesses.empty() || !std::all_of(guesses.begin(), guesses.end(), usable))
    throw Error(ErrorKind::input, "start: expected guesses that are finite, with weights above 0");
}

}  // namespace

void ParticleFilter::start_at(const std::vector<PoseGuess>& guesses) {
  check(guesses);
  State& s = *state_;
  s.begin(mixture_start(s.map, guesses, s.config.most_particles(), s.config.seed, 0));
}

void ParticleFilter::relocate(const std::vector<PoseGuess>& guesses, const Pose& odometry) {
  check(guesses);
  State& s = *state_;
  const auto step = static_cast<std::uint32_t>(s.steps);
  s.backend->upload(mixture_start(s.map, guesses, s.config.most_particles(), s.config.seed, step));
  s.front_end.set_odometry(odometry);
  for (LidarState& lidar : s.lidars) lidar.odometry.reset();  // the next scan counts, however near
  s.last = {};
  s.started = true;
}

void ParticleFilter::propose(const PoseGuess& guess, double share, const SlipPrior& slip) {
  check({guess});
  State& s = *state_;
  ParticleSet set = s.backend->download();
  propose_particles(set, s.map, guess, share, slip, static_cast<std::uint32_t>(s.steps), s.config.seed);
  s.backend->upload(std::move(set));
}

bool ParticleFilter::counts(const Pose& odometry, const Scan& scan) const {
  const State& s = *state_;
  for (std::size_t k = 0; k < s.lidars.size(); ++k)
    if (s.front_end.intake().used()[k].name == scan.sensor)
      return s.front_end.moved_enough(s.lidars[k].odometry, odometry);
  return true;
}

void ParticleFilter::set_seed(std::uint64_t seed) {
  state_->config.seed = seed;
}

void ParticleFilter::add_odometry(double stamp_s, const Pose& odometry) {
  state_->front_end.add_odometry(stamp_s, odometry);
}

std::optional<OdometryReading> ParticleFilter::prepare_odometry(double stamp_s, const Pose& odometry) {
  return state_->front_end.prepare_odometry(stamp_s, odometry);
}

Estimate ParticleFilter::step(const Pose& recorded, const Scan& scan) {
  State& s = *state_;
  if (!s.started) throw Error(ErrorKind::internal, "ParticleFilter::step before start_at or start_anywhere");
  const std::optional<OdometryReading> reading = s.front_end.take_odometry(scan.stamp_s, recorded);
  if (!reading) return not_weighed(s.last);
  const Pose odometry = reading->pose;
  const std::size_t lidar = s.lidar_of(scan);
  if (!s.front_end.moved_enough(s.lidars[lidar].odometry, odometry)) {
    Estimate e = not_weighed(s.last);
    e.pose = compose(s.last.pose, relative(odometry, *s.front_end.odometry()));
    return e;
  }
  const bool weighted = s.take_in(scan, lidar);
  s.lidars[lidar].odometry = odometry;

  s.backend->predict(s.motion_to(odometry), s.key());  // Paz et al. 2012, eq. 6 to 8
  if (weighted) {
    s.backend->set_scan(s.beams);
    s.backend->weight(true);  // algorithms 1 and 3, fused
  }
  s.backend->normalise_scan();
  s.backend->estimate();  // eq. 13, with a circular mean; before resampling
  if (weighted) {
    s.backend->adapt(s.key(), s.may_widen_next());  // Fox 2003, where the number of particles is not fixed
    s.backend->resample(s.key());                   // algorithm 4, when N_eff or the scans ask for it
  }
  const Estimate e = to_estimate(s.backend->finish(), s.config, s.map.T_map_grid, weighted);
  s.remember(e);
  ++s.steps;
  return e;
}

std::vector<Particle> ParticleFilter::particles(std::size_t most) const {
  return in_map_frame(state_->backend->download(), state_->map.T_map_grid, most);
}

const BeamTable& ParticleFilter::last_beams() const {
  return state_->beams;
}
BeamTable ParticleFilter::beams(const Scan& scan) const {
  return state_->front_end.beams_of(scan, state_->config.sensor, state_->map.resolution_m);
}
const std::optional<Pose>& ParticleFilter::odometry() const {
  return state_->front_end.odometry();
}
BeamCounts ParticleFilter::beam_counts() const {
  return state_->front_end.intake().total();
}
const std::vector<LidarUse>& ParticleFilter::lidars_used() const {
  return state_->front_end.intake().used();
}
std::vector<EndPoint> ParticleFilter::end_points(const Scan& scan) const {
  return state_->front_end.end_points_of(scan);
}
std::size_t ParticleFilter::odometry_jumps() const {
  return state_->front_end.continuous().jumps();
}
std::size_t ParticleFilter::odometry_invalid() const {
  return state_->front_end.continuous().invalid();
}
std::size_t ParticleFilter::steps() const {
  return state_->steps;
}
std::string ParticleFilter::backend_name() const {
  return state_->backend->name();
}
const FilterConfig& ParticleFilter::config() const {
  return state_->config;
}
const GridMap& ParticleFilter::map() const {
  return state_->map;
}

std::string ParticleFilter::digest() const {
  return state_->digest.hex_with(state_->backend->download());
}

}  // namespace parloc
