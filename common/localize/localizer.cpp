#include "common/localize/localizer.h"

#include <algorithm>
#include <cmath>

#include "common/localize/place_evidence.h"
#include "common/search/global_search.h"

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
constexpr double kNoDoubt = 0.99, kNoMatter = 0.01;
/// What the probability is worth as long as there may be a rival elsewhere.
constexpr double kUnsettled = 0.7;
/// A hypothesis this close to a mode is the same place.
constexpr double kSame_m = 1.0, kSame_rad = 0.5;

bool same_place(const Pose& a, const Pose& b) {
  return distance_m(a, b) < kSame_m && turn_rad(a, b) < kSame_rad;
}

}  // namespace

struct Localizer::State {
  State(const LocalizerConfig& c, const GridMap& map)
      : config(c), filter(c, map), judge(map, c.search.effective_beams) {}

  void begin(bool is_lost, bool is_settled, const SearchPrior& known);
  std::vector<Mode> modes_at(const Pose& odometry) const;
  bool search_is_due(const Pose& odometry, double stamp_s) const;
  std::vector<Hypothesis> search_map(const Pose& odometry, const BeamTable& beams, LocalizerEstimate& out);
  void look_everywhere(const Pose& odometry, const BeamTable& beams, LocalizerEstimate& out);
  void look_for_others(const Pose& odometry, const BeamTable& beams, LocalizerEstimate& out);
  void drop_refuted(const Pose& odometry, const BeamTable& beams);
  bool fits_again(const Pose& odometry, const BeamTable& beams);
  void settle(const Pose& odometry, const Scan& scan, LocalizerEstimate& out);
  void watch(const Pose& odometry, double stamp_s, LocalizerEstimate& out);

  LocalizerConfig config;
  ParticleFilter filter;
  std::unique_ptr<GlobalSearch> search;  // made when there is something to search
  PlaceEvidence judge;                   // remembers scans from where the doubt began
  SearchPrior prior;
  HealthMonitor monitor;
  bool placed = false;       // it was told or has found where it may be, since the start
  bool lost = true;          // search at the next scan
  bool was_settled = false;  // until it was lost; no search has found another place since
  bool settled = false;      // else there may be other places, as good as the filter's
  std::optional<double> searched_s, lost_since_s;
  Pose searched_odometry;
  std::size_t searches = 0;
  Health last;
};

void Localizer::State::begin(bool is_lost, bool is_settled, const SearchPrior& known) {
  monitor.reset();
  judge.forget();
  prior = known;
  placed = !is_lost;
  lost = is_lost;
  settled = is_settled;
  was_settled = false;
  searched_s.reset();
  lost_since_s.reset();
  searches = 0;
  last = {};
}

bool Localizer::State::search_is_due(const Pose& odometry, double stamp_s) const {
  // With several guesses a scan is weighed before anything else is looked for.
  if (settled || (!lost && !filter.odometry())) return false;
  if (!config.localize.recover && placed) return false;
  if (lost && placed && lost_since_s && std::fabs(stamp_s - *lost_since_s) < config.localize.search_after_s)
    return false;
  if (!searched_s) return true;
  if (std::fabs(stamp_s - *searched_s) < config.localize.search_every_s) return false;
  return lost || distance_m(odometry, searched_odometry) >= config.localize.search_every_m ||
         turn_rad(odometry, searched_odometry) >= config.localize.search_every_rad;
}

/// Every place where this scan may have been taken, weighed by what is remembered, the most likely first.
std::vector<Hypothesis> Localizer::State::search_map(const Pose& odometry, const BeamTable& beams,
                                                     LocalizerEstimate& out) {
  if (!search) search = std::make_unique<GlobalSearch>(filter.map(), config.search, config);
  std::vector<Hypothesis> found = search->search(beams, prior).hypotheses;
  ++searches;
  out.searched = true;
  out.found = found.size();
  std::vector<Pose> places;
  for (const Hypothesis& h : found) places.push_back(h.pose);
  const std::vector<PlaceEvidence::Verdict> verdicts = judge.judge(places, odometry, beams);
  for (std::size_t k = 0; k < found.size(); ++k)
    found[k].evidence = verdicts[k].evidence, found[k].weight = verdicts[k].share;
  std::stable_sort(found.begin(), found.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.weight > b.weight; });
  return found;
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
void Localizer::State::look_everywhere(const Pose& odometry, const BeamTable& beams, LocalizerEstimate& out) {
  std::vector<Hypothesis> found = search_map(odometry, beams, out);
  if (found.empty() || (placed && found[0].evidence < kFits)) return;
  settled = found[0].weight >= kNoDoubt;
  if (settled) found.resize(1);
  const double equal = 1.0 / static_cast<double>(found.size());
  std::vector<PoseGuess> guesses;
  for (const Hypothesis& h : found)
    guesses.push_back({h.pose, kFoundSigma_m, kFoundSigma_rad, std::max(h.weight, kLeastShare * equal)});
  if (placed && filter.odometry()) {
    for (const Mode& mode : modes_at(odometry)) {
      const auto again = [&](const Hypothesis& h) { return same_place(mode.pose, h.pose); };
      if (std::any_of(found.begin(), found.end(), again)) continue;
      guesses.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, kLeastShare * mode.weight});
      settled = false;
    }
  }
  filter.relocate(guesses, odometry);
  was_settled = false;
  monitor.reset();
  placed = true;
  lost = false;
}

/// Whether another place explains this scan, too. If so, it gets its share of the particles; if not, and the
/// filter has made up its mind, that is settled.
void Localizer::State::look_for_others(const Pose& odometry, const BeamTable& beams, LocalizerEstimate& out) {
  const std::vector<Mode> modes = modes_at(odometry);
  std::vector<PoseGuess> others;
  double elsewhere = 0.0;
  for (const Hypothesis& h : search_map(odometry, beams, out)) {
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

/// Of several places, those that the walls speak against lose their particles, before the scan is weighed:
/// the filter's model may see where the beams end only, and not what they went through.
void Localizer::State::drop_refuted(const Pose& odometry, const BeamTable& beams) {
  const std::vector<Mode> modes = modes_at(odometry);
  if (modes.size() < 2 || beams.count == 0) return;
  std::vector<Pose> places;
  for (const Mode& mode : modes) places.push_back(mode.pose);
  const std::vector<PlaceEvidence::Verdict> verdicts = judge.judge(places, odometry, beams);
  double best = 0.0;
  for (const PlaceEvidence::Verdict& v : verdicts) best = std::max(best, v.share);
  std::vector<PoseGuess> left;
  for (std::size_t k = 0; k < modes.size(); ++k)
    if (verdicts[k].share >= kNoMatter * best)
      left.push_back({modes[k].pose, kModeSigma_m, kModeSigma_rad, modes[k].weight});
  if (left.size() < modes.size()) filter.relocate(left, odometry);
}

/// Whether the scan speaks for the place where it was before it was lost.
bool Localizer::State::fits_again(const Pose& odometry, const BeamTable& beams) {
  if (!was_settled || !filter.odometry()) return false;
  const std::vector<Mode> modes = modes_at(odometry);
  return !modes.empty() && judge.evidence(beams, modes[0].pose) >= kFits;
}

/// Before a scan is weighed: whether there are other places where the robot may be.
void Localizer::State::settle(const Pose& odometry, const Scan& scan, LocalizerEstimate& out) {
  const bool search_now = search_is_due(odometry, scan.stamp_s);
  if (!search_now && (settled || lost || !config.localize.recover || !filter.odometry())) return;
  const BeamTable beams = filter.beams(scan);
  if (!search_now) return drop_refuted(odometry, beams);
  if (lost && fits_again(odometry, beams)) return;
  searched_s = scan.stamp_s;
  searched_odometry = odometry;
  lost ? look_everywhere(odometry, beams, out) : look_for_others(odometry, beams, out);
}

/// Health of the estimate, after a scan was weighed.
void Localizer::State::watch(const Pose& odometry, double stamp_s, LocalizerEstimate& out) {
  const PoseEstimate& heaviest = out.filter.cluster;
  last = monitor.update(stamp_s, judge.evidence(filter.last_beams(), heaviest.mean), heaviest.weight);
  const bool was_lost = lost;
  lost = last.state == HealthState::lost;
  if (lost && settled) settled = false, was_settled = true;
  if (!lost && was_settled) settled = true, was_settled = false;  // some bad scans, and it fits again
  if (!lost) {
    lost_since_s.reset();
  } else if (!lost_since_s) {
    lost_since_s = stamp_s;
  }
  if (settled || (lost && !was_lost)) judge.forget();  // it may have been put somewhere else
  if (!settled) judge.remember(odometry, filter.last_beams());
  if (settled || !config.localize.recover) return;
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
  if (!is_finite(odometry)) {  // nothing moves, nothing is learnt
    out.filter = s.filter.step(odometry, scan);
    out.health = s.last;
    return out;
  }
  s.settle(odometry, scan, out);
  out.filter = s.filter.step(odometry, scan);
  if (out.filter.weighted) s.watch(odometry, scan.stamp_s, out);
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
