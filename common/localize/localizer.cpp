#include "common/localize/localizer.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"
#include "common/search/global_search.h"
#include "common/search/scan_evidence.h"

namespace parloc {
namespace {

/// Particles are put about a hypothesis with this spread: of the search's last refinement.
constexpr double kFoundSigma_m = 0.07, kFoundSigma_rad = 0.035;
constexpr double kModeSigma_m = 0.05, kModeSigma_rad = 0.02;  ///< And about what it already stands for.
/// No hypothesis gets fewer particles than this share of an equal part: a wrong ranking must be able to turn.
constexpr double kLeastShare = 0.25;
constexpr double kLeastMode = 0.02;
/// Evidence of a scan that may tell where it was taken [nat per beam]: one of less is bad itself.
constexpr double kFits = 1.0;
/// Shares of all that the search finds: from here on there is no doubt, and up to here none worth a particle.
constexpr double kNoDoubt = 0.98, kNoMatter = 0.02;
/// What the probability is worth as long as there may be a rival elsewhere.
constexpr double kUnsettled = 0.7;
/// A hypothesis this close to a mode is the same place.
constexpr double kSame_m = 1.0, kSame_rad = 0.5;

double turn_between(const Pose& a, const Pose& b) {
  return std::fabs(wrap64(a.theta_rad - b.theta_rad));
}
double distance_between(const Pose& a, const Pose& b) {
  const double dx = a.x_m - b.x_m, dy = a.y_m - b.y_m;
  return std::sqrt(dx * dx + dy * dy);
}
bool finite(const Pose& p) {
  return std::isfinite(p.x_m) && std::isfinite(p.y_m) && std::isfinite(p.theta_rad);
}
bool same_place(const Pose& a, const Pose& b) {
  return distance_between(a, b) < kSame_m && turn_between(a, b) < kSame_rad;
}

}  // namespace

LocalizerConfig localizer_config(const FilterConfig& config) {
  LocalizerConfig c;
  c.filter = config;
  c.search = config.search;
  c.search.backend = config.backend, c.search.threads = config.threads, c.search.device = config.device;
  c.recover = config.localize.recover;
  return c;
}

struct Localizer::State {
  State(const LocalizerConfig& c, const GridMap& map)
      : config(c), filter(c.filter, map), evidence(map), T_map_grid(map.T_map_grid) {}

  void begin(bool is_lost, bool is_settled, const SearchPrior& known);
  std::vector<Mode> modes_at(const Pose& odometry) const;
  bool search_is_due(const Pose& odometry, double stamp_s) const;
  std::vector<Hypothesis> search_map(const Pose& odometry, const Scan& scan, LocalizerEstimate& out);
  void look_everywhere(const Pose& odometry, const Scan& scan, LocalizerEstimate& out);
  void look_for_others(const Pose& odometry, const Scan& scan, LocalizerEstimate& out);
  void judge(const Scan& scan, LocalizerEstimate& out);

  LocalizerConfig config;
  ParticleFilter filter;
  std::unique_ptr<GlobalSearch> search;  // made when there is something to search
  ScanEvidence evidence;
  Pose T_map_grid;
  SearchPrior prior;
  HealthMonitor monitor;
  bool placed = false;   // it was told or has found where it may be, since the start
  bool lost = true;      // search at the next scan
  bool settled = false;  // else there may be other places, as good as the filter's
  std::optional<double> searched_s, lost_since_s;
  Pose searched_odometry;
  std::size_t searches = 0;
  Health last;
};

void Localizer::State::begin(bool is_lost, bool is_settled, const SearchPrior& known) {
  monitor.reset();
  prior = known;
  placed = !is_lost;
  lost = is_lost;
  settled = is_settled;
  searched_s.reset();
  lost_since_s.reset();
  searches = 0;
  last = {};
}

bool Localizer::State::search_is_due(const Pose& odometry, double stamp_s) const {
  // With several guesses a scan is weighed before anything else is looked for.
  if (settled || (!lost && !filter.odometry())) return false;
  if (!config.recover && placed) return false;
  if (lost && placed && lost_since_s && std::fabs(stamp_s - *lost_since_s) < config.search_after_s)
    return false;
  if (!searched_s) return true;
  if (std::fabs(stamp_s - *searched_s) < config.search_every_s) return false;
  return lost || distance_between(odometry, searched_odometry) >= config.search_every_m ||
         turn_between(odometry, searched_odometry) >= config.search_every_rad;
}

std::vector<Hypothesis> Localizer::State::search_map(const Pose& odometry, const Scan& scan,
                                                     LocalizerEstimate& out) {
  if (!search) search = std::make_unique<GlobalSearch>(filter.map(), config.search);
  SearchResult result = search->search(filter.beams(scan), prior);
  searched_s = scan.stamp_s;
  searched_odometry = odometry;
  ++searches;
  out.searched = true;
  out.found = result.hypotheses.size();
  return std::move(result.hypotheses);
}

/// What the filter stands for, moved to where the robot is by the odometry.
std::vector<Mode> Localizer::State::modes_at(const Pose& odometry) const {
  const Pose moved = relative(odometry, *filter.odometry());
  std::vector<Mode> modes = find_modes(filter.particles(), kLeastMode);
  for (Mode& mode : modes) mode.pose = compose(mode.pose, moved);
  return modes;
}

/// Puts the particles where the scan may have been taken. Leaves them where they are if it fits nowhere well:
/// then it may be the scan that is bad. Some stay where they are in any case, if that was a place.
void Localizer::State::look_everywhere(const Pose& odometry, const Scan& scan, LocalizerEstimate& out) {
  const std::vector<Hypothesis> found = search_map(odometry, scan, out);
  if (found.empty() || (placed && found[0].evidence < kFits)) return;
  const double equal = 1.0 / static_cast<double>(found.size());
  std::vector<PoseGuess> guesses;
  for (const Hypothesis& h : found)
    guesses.push_back({h.pose, kFoundSigma_m, kFoundSigma_rad, std::max(h.weight, kLeastShare * equal)});
  settled = found[0].weight >= kNoDoubt;
  if (placed && filter.odometry()) {
    for (const Mode& mode : modes_at(odometry)) {
      const auto again = [&](const Hypothesis& h) { return same_place(mode.pose, h.pose); };
      if (std::any_of(found.begin(), found.end(), again)) continue;
      guesses.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, kLeastShare * mode.weight});
      settled = false;
    }
  }
  filter.relocate(guesses, odometry);
  monitor.reset();
  placed = true;
  lost = false;
}

/// Whether another place explains this scan, too. If so, it gets its share of the particles; if not, and the
/// filter has made up its mind, that is settled.
void Localizer::State::look_for_others(const Pose& odometry, const Scan& scan, LocalizerEstimate& out) {
  const std::vector<Mode> modes = modes_at(odometry);
  std::vector<PoseGuess> others;
  double elsewhere = 0.0;
  for (const Hypothesis& h : search_map(odometry, scan, out)) {
    const auto known = [&](const Mode& mode) { return same_place(mode.pose, h.pose); };
    if (h.weight < kNoMatter || std::any_of(modes.begin(), modes.end(), known)) continue;
    others.push_back({h.pose, kFoundSigma_m, kFoundSigma_rad, h.weight});
    elsewhere += h.weight;
  }
  if (others.empty()) {
    settled = out.found > 0 && !modes.empty() && modes[0].weight >= 1.0 - kNoMatter;
    return;
  }
  for (const Mode& mode : modes)
    others.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, (1.0 - elsewhere) * mode.weight + 1e-6});
  filter.relocate(others, odometry);
}

/// Health of the estimate, and the other places while there are some.
void Localizer::State::judge(const Scan& scan, LocalizerEstimate& out) {
  const PoseEstimate& heaviest = out.filter.cluster;
  const double fits = evidence.per_beam(filter.last_beams(), relative(heaviest.mean, T_map_grid));
  last = monitor.update(scan.stamp_s, fits, heaviest.weight);
  lost = last.state == HealthState::lost;
  if (lost) settled = false;
  if (!lost) {
    lost_since_s.reset();
  } else if (!lost_since_s) {
    lost_since_s = scan.stamp_s;
  }
  if (settled || !config.recover) return;
  last.probability *= kUnsettled;
  if (last.state == HealthState::tracking) last.state = HealthState::ambiguous;
}

Localizer::Localizer(const LocalizerConfig& config, const GridMap& map)
    : state_(std::make_unique<State>(config, map)) {
  validate(config.search);
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

void Localizer::start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m,
                         double sigma_theta_rad) {
  state_->filter.start_at(pose_in_map, sigma_x_m, sigma_y_m, sigma_theta_rad);
  state_->begin(false, true, {});
}

void Localizer::start_at(const std::vector<PoseGuess>& guesses) {
  state_->filter.start_at(guesses);
  state_->begin(false, guesses.size() == 1, {});
}

void Localizer::start_anywhere(const SearchPrior& prior) {
  state_->filter.start_anywhere();
  state_->begin(true, false, prior);
}

void Localizer::set_seed(std::uint64_t seed) {
  state_->filter.set_seed(seed);
}

void Localizer::add_odometry(double stamp_s, const Pose& odometry) {
  state_->filter.add_odometry(stamp_s, odometry);
}

LocalizerEstimate Localizer::step(const Pose& odometry, const Scan& scan) {
  State& s = *state_;
  LocalizerEstimate out;
  if (!finite(odometry)) {  // nothing moves, nothing is learnt
    out.filter = s.filter.step(odometry, scan);
    out.health = s.last;
    return out;
  }
  if (s.search_is_due(odometry, scan.stamp_s))
    s.lost ? s.look_everywhere(odometry, scan, out) : s.look_for_others(odometry, scan, out);
  out.filter = s.filter.step(odometry, scan);
  if (out.filter.weighted) s.judge(scan, out);
  out.health = s.last;
  if (out.health.state == HealthState::ambiguous) out.modes = find_modes(s.filter.particles(), kLeastMode);
  return out;
}

const ParticleFilter& Localizer::filter() const {
  return state_->filter;
}
std::size_t Localizer::searches() const {
  return state_->searches;
}

}  // namespace parloc
