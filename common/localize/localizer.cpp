#include "common/localize/localizer.h"

#include <algorithm>
#include <cmath>

#include "common/localize/scan_evidence.h"
#include "common/search/global_search.h"

namespace parloc {
namespace {

/// Particles are put about a hypothesis with this spread: of the search's last refinement.
constexpr double kFoundSigma_m = 0.07, kFoundSigma_rad = 0.035;
/// No hypothesis gets fewer particles than this share of an equal part: a wrong ranking must be able to turn.
constexpr double kLeastShare = 0.25;
constexpr double kLeastMode = 0.02;

}  // namespace

struct Localizer::State {
  State(const LocalizerConfig& c, const GridMap& map)
      : config(c), filter(c.filter, map), search(map, c.search), evidence(map), T_map_grid(map.T_map_grid) {}

  bool search_is_due(double stamp_s) const;
  bool look_everywhere(const Pose& odometry, const Scan& scan, LocalizerEstimate& out);
  void judge(const Scan& scan, LocalizerEstimate& out);

  LocalizerConfig config;
  ParticleFilter filter;
  GlobalSearch search;
  ScanEvidence evidence;
  Pose T_map_grid;
  SearchPrior prior;
  HealthMonitor monitor;
  bool lost = true;  // search at the next scan
  std::optional<double> searched_s;
  std::size_t searches = 0;
  Health last;
};

bool Localizer::State::search_is_due(double stamp_s) const {
  if (!lost || (searches > 0 && !config.recover)) return false;
  return !searched_s || std::fabs(stamp_s - *searched_s) >= config.search_every_s;
}

/// Puts the particles where the scan may have been taken; false if it fits nowhere.
bool Localizer::State::look_everywhere(const Pose& odometry, const Scan& scan, LocalizerEstimate& out) {
  const SearchResult result = search.search(filter.beams(scan), prior);
  searched_s = scan.stamp_s;
  ++searches;
  out.searched = true;
  out.found = result.hypotheses.size();
  if (result.hypotheses.empty()) return false;
  const double equal = 1.0 / static_cast<double>(result.hypotheses.size());
  std::vector<PoseGuess> guesses;
  for (const Hypothesis& h : result.hypotheses)
    guesses.push_back(
        {h.pose, kFoundSigma_m, kFoundSigma_rad, std::max(h.weight, kLeastShare * equal)});
  filter.relocate(guesses, odometry);
  monitor.reset();
  lost = false;
  return true;
}

/// Health of the estimate, and the other places while there are some.
void Localizer::State::judge(const Scan& scan, LocalizerEstimate& out) {
  const PoseEstimate& heaviest = out.filter.cluster;
  const double fits =
      evidence.per_beam(filter.beams(scan), relative(heaviest.mean, T_map_grid));
  last = monitor.update(scan.stamp_s, fits, heaviest.weight);
  lost = last.state == HealthState::lost;
}

Localizer::Localizer(const LocalizerConfig& config, const GridMap& map)
    : state_(std::make_unique<State>(config, map)) {}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

void Localizer::start_at(const std::vector<PoseGuess>& guesses) {
  State& s = *state_;
  s.filter.start_at(guesses);
  s.monitor.reset();
  s.prior = {};
  s.lost = false;
  s.searched_s.reset();
  s.searches = 0;
  s.last = {};
}

void Localizer::start_anywhere(const SearchPrior& prior) {
  State& s = *state_;
  s.filter.start_anywhere();
  s.monitor.reset();
  s.prior = prior;
  s.lost = true;
  s.searched_s.reset();
  s.searches = 0;
  s.last = {};
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
  if (s.search_is_due(scan.stamp_s)) s.look_everywhere(odometry, scan, out);
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
