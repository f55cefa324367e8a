#include "common/filter/particle_filter.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <utility>

#include "common/error.h"
#include "common/filter/filter_run.h"
#include "common/filter/map_frame.h"
#include "common/filter/propose_particles.h"
#include "common/filter/start.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kHeadingUndefined = 1e-3;  // resultant below which a circular mean means nothing (SPEC 4)

const PoseEstimate& chosen_of(const Estimate& e, const FilterConfig& config) {
  return config.estimate.mode == EstimateMode::mean ? e.mean : e.cluster;
}

Estimate to_estimate(const StepState& s, const FilterConfig& config, const Pose& T_map_grid, bool weighted) {
  Estimate e;
  e.mean = in_map_frame(s.all, T_map_grid);
  e.cluster = in_map_frame(s.cluster, T_map_grid);
  e.ambiguous_heading = e.mean.heading_resultant < kHeadingUndefined;
  if (e.ambiguous_heading) e.mean.mean.theta_rad = e.cluster.mean.theta_rad;
  const PoseEstimate& chosen = chosen_of(e, config);
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

/// What the filter remembers of one LiDAR.
struct LidarState {
  double range_max_m = 0.0;      ///< Of its last scan.
  std::optional<Pose> odometry;  ///< At its last processed scan.
};

}  // namespace

struct ParticleFilter::State : RunConfig<FilterConfig>, Run {
  State(const FilterConfig& c, const GridMap& on) : RunConfig{c}, Run(config, on) {}
  ParticleSet download() const override { return backend->download(); }
  std::string backend_name() const override { return backend->name(); }

  std::unique_ptr<FilterBackend> backend;
  std::vector<LidarState> lidars;         // one per LiDAR seen
  std::atomic<double> range_max_m = 0.0;  // that the backend's tables are made for; prepare_map reads it
  int unlikely_scans = 0;                 // in a row, up to the last one
  int widenings_due = 0;                  // in units of the configured noise, in the next step

  std::unique_ptr<FilterBackend> make_backend(const GridMap& on) const;
  void begin(ParticleSet set);
  void put(ParticleSet set, const std::optional<Pose>& odometry);
  void put(ParticleSet set, const PoseEstimate& there);
  Estimate not_counted(const Pose& odometry, double stamp_s);
  std::size_t lidar_of(const Scan& scan);
  MotionStep motion_to(const Pose& odometry);
  bool may_widen_next() const;
  void watch_likelihood(const Estimate& e);
  bool take_in(const Scan& scan, std::size_t lidar);
};

ParticleFilter::State& ParticleFilter::state() {
  return static_cast<State&>(*run_);
}
const ParticleFilter::State& ParticleFilter::state() const {
  return static_cast<const State&>(*run_);
}

void ParticleFilter::State::begin(ParticleSet set) {
  backend->upload(std::move(set));
  Run::begin();
  lidars.clear();
  unlikely_scans = widenings_due = 0;
}

std::size_t ParticleFilter::State::lidar_of(const Scan& scan) {
  const std::size_t lidar = front_end.lidar_of(scan);
  lidars.resize(front_end.lidars_used().size());
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
    backend->set_range_max(farthest_m);
    range_max_m = farthest_m;
  }
  return true;
}

ParticleFilter::ParticleFilter(const FilterConfig& config, const GridMap& map)
    : PoseFilter(std::make_unique<State>(config, map)) {
  validate(config);
  state().backend = state().make_backend(map);
}

std::unique_ptr<FilterBackend> ParticleFilter::State::make_backend(const GridMap& on) const {
  check_map(on);
  std::string why;
  const FilterConfig& c = config;
  std::unique_ptr<FilterBackend> made =
      make_filter_backend(c.backend,
                          {c.most_particles(), c.threads, c.device, c.sensor, c.resample,
                           c.fewest_particles(), c.kld, c.recovery, c.group},
                          why);
  made->set_map(on);
  return made;
}

void ParticleFilter::start_at(const Pose& pose, const Covariance& covariance) {
  State& s = state();
  check_start(s.map, pose, covariance);
  s.begin(gaussian_start(s.map, pose, root_of(covariance), s.config.most_particles(), s.config.seed));
}

void ParticleFilter::start_anywhere() {
  State& s = state();
  s.begin(uniform_start(s.map, s.config.most_particles(), s.config.seed));
}

namespace {

void check_guesses(const std::vector<PoseGuess>& guesses) {
  const auto usable = [](const PoseGuess& g) {
    return is_finite(g.pose) && g.sigma_xy_m >= 0 && std::isfinite(g.sigma_xy_m) && g.sigma_theta_rad >= 0 &&
           std::isfinite(g.sigma_theta_rad) && g.weight > 0 && std::isfinite(g.weight);
  };
  if (guesses.empty() || !std::all_of(guesses.begin(), guesses.end(), usable))
    throw Error(ErrorKind::input, "start: expected guesses that are finite, with weights above 0");
}
void check_inside(const std::vector<PoseGuess>& guesses, const GridMap& map) {
  check_guesses(guesses);
  for (const PoseGuess& g : guesses) check_start(map, g.pose, g.sigma_xy_m, g.sigma_xy_m, g.sigma_theta_rad);
}

}  // namespace

void ParticleFilter::start_at(const std::vector<PoseGuess>& guesses) {
  State& s = state();
  check_inside(guesses, s.map);
  s.begin(mixture_start(s.map, guesses, s.config.most_particles(), s.config.seed, 0));
}

void ParticleFilter::relocate(const std::vector<PoseGuess>& guesses, const Pose& odometry) {
  check_guesses(guesses);
  State& s = state();
  const auto step = static_cast<std::uint32_t>(s.steps);
  s.put(mixture_start(s.map, guesses, s.config.most_particles(), s.config.seed, step), odometry);
}

void ParticleFilter::relocate(const std::vector<PoseGuess>& guesses) {
  State& s = state();
  s.expect_started();
  check_inside(guesses, s.map);
  const auto step = static_cast<std::uint32_t>(s.steps);
  const PoseGuess& g =
      *std::max_element(guesses.begin(), guesses.end(),
                        [](const PoseGuess& a, const PoseGuess& b) { return a.weight < b.weight; });
  s.put(mixture_start(s.map, guesses, s.config.most_particles(), s.config.seed, step),
        PoseEstimate{g.pose, covariance_of(g.sigma_xy_m, g.sigma_xy_m, g.sigma_theta_rad), 1.0, 1.0});
}

void ParticleFilter::relocate(const Pose& pose, const Covariance& covariance) {
  State& s = state();
  s.expect_started();
  check_start(s.map, pose, covariance);
  const auto step = static_cast<std::uint32_t>(s.steps);
  s.put(gaussian_start(s.map, pose, root_of(covariance), s.config.most_particles(), s.config.seed, step),
        PoseEstimate{pose, covariance, 1.0, 1.0});
}

/// About a pose where the robot is at the last step's odometry.
void ParticleFilter::State::put(ParticleSet set, const PoseEstimate& there) {
  const std::optional<OdometryMemory>& reading = front_end.last_reading();
  put(std::move(set), reading ? std::optional(reading->pose) : std::nullopt);
  given = there;
  given_s = reading ? std::optional(reading->stamp_s) : std::nullopt;
}

void ParticleFilter::State::put(ParticleSet set, const std::optional<Pose>& odometry) {
  backend->upload(std::move(set));
  front_end.set_odometry(odometry);
  for (LidarState& lidar : lidars) lidar.odometry.reset();  // the next scan counts, however near
  last = {};
  started = true;
}

struct ParticleFilter::PreparedMap::Parts {
  GridMap map;
  std::unique_ptr<FilterBackend> backend;
  double range_max_m;
  const State* of;
};
ParticleFilter::PreparedMap::PreparedMap(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ParticleFilter::PreparedMap::PreparedMap(PreparedMap&&) noexcept = default;
ParticleFilter::PreparedMap& ParticleFilter::PreparedMap::operator=(PreparedMap&&) noexcept = default;
ParticleFilter::PreparedMap::~PreparedMap() = default;
const GridMap& ParticleFilter::PreparedMap::map() const {
  return parts_->map;
}

ParticleFilter::PreparedMap ParticleFilter::prepare_map(const GridMap& map) const {
  const State& s = state();
  auto parts = std::make_unique<PreparedMap::Parts>();
  parts->backend = s.make_backend(map);
  parts->map = map;
  parts->range_max_m = s.range_max_m;
  if (parts->range_max_m > 0.0) parts->backend->set_range_max(parts->range_max_m);
  parts->of = &s;
  return PreparedMap(std::move(parts));
}

void ParticleFilter::replace_map(PreparedMap prepared) {
  State& s = state();
  const std::unique_ptr<PreparedMap::Parts> parts = std::move(prepared.parts_);
  if (parts == nullptr || parts->of != &s)
    throw Error(ErrorKind::usage, "replace_map: expected a map that this filter has prepared");
  ParticleSet set = s.started ? s.backend->download() : ParticleSet{};
  in_other_grid(set, s.map.T_map_grid, parts->map.T_map_grid);
  if (s.range_max_m > 0.0 && s.range_max_m != parts->range_max_m)
    parts->backend->set_range_max(s.range_max_m);
  if (s.started) parts->backend->upload(std::move(set));
  s.backend = std::move(parts->backend);
  s.map = std::move(parts->map);
}

void ParticleFilter::propose(const PoseGuess& guess, double share, const SlipPrior& slip) {
  check_guesses({guess});
  State& s = state();
  ParticleSet set = s.backend->download();
  propose_particles(set, s.map, guess, share, slip, static_cast<std::uint32_t>(s.steps), s.config.seed);
  s.backend->upload(std::move(set));
}

void ParticleFilter::weigh_next() {
  for (LidarState& lidar : state().lidars) lidar.odometry.reset();
}

bool ParticleFilter::counts(const Pose& odometry, const Scan& scan) const {
  const State& s = state();
  for (std::size_t k = 0; k < s.lidars.size(); ++k)
    if (s.front_end.lidars_used()[k].name == scan.sensor)
      return s.front_end.moved_enough(s.lidars[k].odometry, odometry);
  return true;
}

/// The last estimate, moved by the odometry alone; its covariances stay those of the last scan.
Estimate ParticleFilter::State::not_counted(const Pose& odometry, double stamp_s) {
  why_skipped = "too little motion";
  Estimate e = not_weighed();
  e.stamp_s = stamp_s;
  const Pose motion = relative(odometry, *front_end.odometry());
  for (Pose* const pose : {&e.pose, &e.mean.mean, &e.cluster.mean}) *pose = compose(*pose, motion);
  given = chosen_of(e, config);
  given_s = stamp_s;
  return e;
}

Estimate ParticleFilter::step(const Pose& recorded, const Scan& scan) {
  State& s = state();
  const std::optional<OdometryReading> reading = s.take(recorded, scan);
  if (!reading) return s.not_weighed();
  const Pose odometry = reading->pose;
  const std::size_t lidar = s.lidar_of(scan);
  if (!s.front_end.moved_enough(s.lidars[lidar].odometry, odometry))
    return s.not_counted(odometry, scan.stamp_s);
  const bool weighted = s.take_in(scan, lidar);
  s.why_skipped = weighted ? "" : "too few beams";
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
  Estimate e = to_estimate(s.backend->finish(), s.config, s.map.T_map_grid, weighted);
  e.stamp_s = scan.stamp_s;
  if (weighted) s.watch_likelihood(e);
  s.remember(e, chosen_of(e, s.config));
  return e;
}

const BeamTable& ParticleFilter::last_beams() const {
  return state().beams;
}
BeamTable ParticleFilter::beams(const Scan& scan) const {
  const State& s = state();
  return s.front_end.beams_of(scan, s.config.sensor, s.map.resolution_m);
}
const std::optional<Pose>& ParticleFilter::odometry() const {
  return state().front_end.odometry();
}
std::vector<EndPoint> ParticleFilter::end_points(const Scan& scan) const {
  return state().front_end.end_points_of(scan);
}
const FilterConfig& ParticleFilter::config() const {
  return state().config;
}

}  // namespace parloc
