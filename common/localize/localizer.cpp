#include "common/localize/localizer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/localize/map_error.h"
#include "common/localize/missing_returns.h"
#include "common/localize/place_evidence.h"
#include "common/localize/rivals.h"
#include "common/localize/scan_novelty.h"
#include "common/localize/slip_search.h"
#include "common/math/portable64.h"
#include "common/search/global_search.h"

namespace parloc {
namespace {

/// Particles are put about a hypothesis with this spread: of the search's last refinement.
constexpr double kFoundSigma_m = 0.07, kFoundSigma_rad = 0.035;
constexpr double kModeSigma_m = 0.05, kModeSigma_rad = 0.02;  ///< And about what it already stands for.
/// No hypothesis gets fewer particles than this share of an equal part: a wrong ranking must be able to turn.
constexpr double kLeastShare = 0.25;
constexpr double kLeastMode = 0.02;
/// Shares of all that the search finds: from here on there is no doubt, and up to here none worth a particle.
constexpr double kNoDoubt = 0.99, kNoMatter = 0.01;
/// What the probability is worth as long as there may be a rival elsewhere.
constexpr double kUnsettled = 0.7;
/// A hypothesis this close to a mode is the same place.
constexpr double kSame_m = 1.0, kSame_rad = 0.5;

/// A start that was given is believed, about; a place that the search has chosen has to show itself.
constexpr double kGivenLogOdds = 2.0, kFoundLogOdds = 0.5, kTrusted = 5.0;

constexpr double kSlipShare = 0.25;  ///< Of the particles, for what is found there.

/// Work of a slice of the search (search_work.h), 2 to 3 ns each on a core: the longer the time between
/// scans, the more, but always some milliseconds.
constexpr double kWorkPer_s = 4e7, kLeastSlice = 2e6, kMostSlice = 5e6;
constexpr std::int64_t kAllWork = std::numeric_limits<std::int64_t>::max();
constexpr double kSearchEvery_s = 2.0;  ///< Or sooner, if it has moved.

bool same_place(const Pose& a, const Pose& b) {
  return distance_m(a, b) < kSame_m && turn_rad(a, b) < kSame_rad;
}

/// What is known at a step before its scan is weighed.
struct Now {
  Pose odometry;
  double elapsed_s;
  const BeamTable& beams;
};

std::int64_t slice_of(const Now& now) {
  return static_cast<std::int64_t>(std::clamp(kWorkPer_s * now.elapsed_s, kLeastSlice, kMostSlice));
}

}  // namespace

struct Localizer::State {
  State(const LocalizerConfig& c, const GridMap& map)
      : config(c), filter(c, map), judge(map, c.search.effective_beams) {}

  void begin(bool is_lost, bool is_settled, const SearchPrior& known);
  GlobalSearch& whole_map();
  SlipSearch& near_by();
  std::vector<Mode> modes_at(const Pose& odometry) const;
  bool search_is_due(const Pose& odometry) const;
  void start_search(const Now& now);
  void go_on_searching(const Now& now, LocalizerEstimate& out);
  std::vector<JudgedPlace> found_now(const Now& now, LocalizerEstimate& out);
  void put_at(std::vector<JudgedPlace> found, const Now& now);
  void look_for_others(const std::vector<JudgedPlace>& found, const Now& now);
  void weigh_rivals(const Now& now);
  void drop_refuted(const Now& now);
  bool fits_again(const Now& now);
  void look_for_slips(const Now& now);
  void settle(const Now& now, LocalizerEstimate& out);
  void watch(const Now& now, LocalizerEstimate& out);

  LocalizerConfig config;
  ParticleFilter filter;
  std::unique_ptr<GlobalSearch> search;  // made when there is something to search
  std::unique_ptr<SlipSearch> slips;     // likewise
  PlaceEvidence judge;                   // remembers scans from where the doubt began

  /// Of one run, from start to start.
  struct Drive {
    SearchPrior prior;
    HealthMonitor monitor;
    ScanNovelty novelty;
    MissingReturns missing;
    bool placed = false;                    // it was told or has found where it may be, since the start
    bool lost = true;                       // search
    bool doubt = false;                     // more speaks against it than for it, since a little while
    bool settled = false;                   // else there may be other places, as good as the filter's
    bool found = false;                     // it is where a search has put it, and has not shown itself yet
    std::size_t refuted = 0;                // places in a row that did not: perhaps it is nowhere on this map
    bool was_settled = false;               // until it was lost; no search has found another place since
    std::optional<Pose> searched_odometry;  // where the last search began
    double since_search_s = 0.0;
    std::size_t searches = 0;
    Rivals rivals;
    std::optional<Pose> tracked;  // the heaviest cluster, after the last step that was weighed
    double since_well_m = 0.0;
    Health last;
  };
  Drive d;
};

void Localizer::State::begin(bool is_lost, bool is_settled, const SearchPrior& known) {
  judge.forget();
  if (search) search->forget();  // slices end where they would if this run were the first
  judge.set_lost(0.0);
  d = {};
  d.monitor.reset(is_lost ? kFoundLogOdds : kGivenLogOdds);
  d.prior = known;
  d.placed = !is_lost;
  d.lost = is_lost;
  d.settled = is_settled;
}

GlobalSearch& Localizer::State::whole_map() {
  if (!search) search = std::make_unique<GlobalSearch>(filter.map(), config.search, config);
  return *search;
}

SlipSearch& Localizer::State::near_by() {
  if (!slips) {
    ComputeConfig one = config;
    one.threads = 1;  // less than a millisecond of work: to wake others takes as long
    slips = std::make_unique<SlipSearch>(filter.map(), config.search, one, &whole_map());
  }
  return *slips;
}

bool Localizer::State::search_is_due(const Pose& odometry) const {
  // With several guesses a scan is weighed before anything else is looked for.
  if ((d.settled && !d.doubt) || (!d.lost && !filter.odometry())) return false;
  if (d.placed && (!config.localize.recover || !d.rivals.empty())) return false;
  return !d.searched_odometry || d.since_search_s >= kSearchEvery_s ||
         distance_m(odometry, *d.searched_odometry) >= config.localize.search_every_m ||
         turn_rad(odometry, *d.searched_odometry) >= config.localize.search_every_rad;
}

void Localizer::State::start_search(const Now& now) {
  whole_map().begin(now.beams, d.prior);
  d.searched_odometry = now.odometry;
  d.since_search_s = 0.0;
}

/// Every place where the scan of the search may have been taken, moved to now and weighed by what is
/// remembered, the most likely first.
std::vector<JudgedPlace> Localizer::State::found_now(const Now& now, LocalizerEstimate& out) {
  const SearchResult result = search->result();
  out.searched = true;
  ++d.searches;
  out.found = result.hypotheses.size();
  const Pose moved_since = relative(now.odometry, *d.searched_odometry);
  std::vector<Pose> places;
  for (const Hypothesis& h : result.hypotheses) places.push_back(compose(h.pose, moved_since));
  std::vector<JudgedPlace> found = judge.judge(places, now.odometry, now.beams);
  sort_by_share(found);
  return found;
}

/// What the filter stands for, moved to where the robot is by the odometry.
std::vector<Mode> Localizer::State::modes_at(const Pose& odometry) const {
  const Pose moved = relative(odometry, *filter.odometry());
  std::vector<Mode> modes = find_modes(filter.particles(), kLeastMode);
  for (Mode& mode : modes) mode.pose = compose(mode.pose, moved);
  return modes;
}

/// Puts the particles where the scans say that the robot may be. Some stay where they are, if that was a
/// place.
void Localizer::State::put_at(std::vector<JudgedPlace> found, const Now& now) {
  d.settled = found[0].share >= kNoDoubt;
  if (d.settled) found.resize(1);
  const double equal = 1.0 / static_cast<double>(found.size());
  std::vector<PoseGuess> guesses;
  for (const JudgedPlace& place : found)
    guesses.push_back(
        {place.pose, kFoundSigma_m, kFoundSigma_rad, std::max(place.share, kLeastShare * equal)});
  if (d.placed && filter.odometry()) {
    for (const Mode& mode : modes_at(now.odometry)) {
      const auto again = [&](const JudgedPlace& place) { return same_place(mode.pose, place.pose); };
      if (std::any_of(found.begin(), found.end(), again)) continue;
      guesses.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, kLeastShare * mode.weight});
      d.settled = false;
    }
  }
  filter.relocate(guesses, now.odometry);
  if (d.found) ++d.refuted;
  d.found = true;
  d.was_settled = false;
  d.monitor.reset(kFoundLogOdds);
  d.tracked.reset();
  d.rivals.clear();
  d.placed = true;
  d.lost = false;
}

/// Whether another place explains the scan of the search, too. If so, it gets its share of the particles; if
/// not, and the filter has made up its mind, that is settled.
void Localizer::State::look_for_others(const std::vector<JudgedPlace>& found, const Now& now) {
  const std::vector<Mode> modes = modes_at(now.odometry);
  std::vector<PoseGuess> others;
  double elsewhere = 0.0;
  for (const JudgedPlace& place : found) {
    const auto known = [&](const Mode& mode) { return same_place(mode.pose, place.pose); };
    if (place.share < kNoMatter || std::any_of(modes.begin(), modes.end(), known)) continue;
    others.push_back({place.pose, kFoundSigma_m, kFoundSigma_rad, place.share});
    elsewhere += place.share;
  }
  if (others.empty()) {
    d.settled = !found.empty() && !modes.empty() && modes[0].weight >= 1.0 - kNoMatter;
    return;
  }
  for (const Mode& mode : modes)
    others.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, (1.0 - elsewhere) * mode.weight + 1e-6});
  filter.relocate(others, now.odometry);
  d.tracked.reset();
}

/// A slice of the search that is under way, if there is one, and what follows from what it has found.
void Localizer::State::go_on_searching(const Now& now, LocalizerEstimate& out) {
  if (!search || !search->under_way()) return;
  if (d.settled && !d.doubt) return search->cancel();  // some bad scans, and it fits again
  if (!search->advance(d.placed ? slice_of(now) : kAllWork)) return;
  std::vector<JudgedPlace> found = found_now(now, out);
  const bool was_sure = d.settled || d.was_settled;
  if (!d.placed) {
    if (!found.empty()) put_at(std::move(found), now);
  } else if (!was_sure && !d.lost) {
    look_for_others(found, now);
  } else if (!was_sure) {
    if (!found.empty() && found[0].fits()) put_at(std::move(found), now);
  } else {
    const auto is_here = [&](const Pose& pose) {
      return d.tracked && same_place(pose, compose(*d.tracked, relative(now.odometry, *filter.odometry())));
    };
    if (!found.empty() && found[0].fits() && is_here(found[0].pose)) return d.monitor.accept();
    d.rivals.begin(found, search->result().candidates, now.odometry);
  }
}

/// Whether the scans since pay for another place.
void Localizer::State::weigh_rivals(const Now& now) {
  if (d.rivals.empty()) return;
  d.rivals.follow(now.odometry);
  if (d.rivals.empty() || !judge.remember(now.odometry, now.beams)) return;
  std::vector<JudgedPlace> paid =
      d.rivals.weigh(modes_at(now.odometry), now.beams, judge, near_by(), config.localize.carried_per_hour);
  if (!paid.empty()) put_at(std::move(paid), now);
}

/// Of several places, those that the walls speak against lose their particles, before the scan is weighed:
/// the filter's model may see where the beams end only, and not what they went through.
void Localizer::State::drop_refuted(const Now& now) {
  const std::vector<Mode> modes = modes_at(now.odometry);
  if (modes.size() < 2 || now.beams.count == 0) return;
  std::vector<Pose> places;
  for (const Mode& mode : modes) places.push_back(mode.pose);
  const std::vector<JudgedPlace> judged = judge.judge(places, now.odometry, now.beams);
  double best = 0.0;
  for (const JudgedPlace& place : judged) best = std::max(best, place.share);
  std::vector<PoseGuess> left;
  for (std::size_t k = 0; k < modes.size(); ++k)
    if (judged[k].share >= kNoMatter * best)
      left.push_back({modes[k].pose, kModeSigma_m, kModeSigma_rad, modes[k].weight});
  if (left.size() == modes.size()) return;
  filter.relocate(left, now.odometry);
  d.tracked.reset();
}

/// Whether the scan speaks for the place where it was before it was lost.
bool Localizer::State::fits_again(const Now& now) {
  if (!d.was_settled || !filter.odometry()) return false;
  const std::vector<Mode> modes = modes_at(now.odometry);
  return !modes.empty() && judge.fits(now.beams, modes[0].pose);
}

/// If the scan fits the prediction badly, the wheels may have slipped: what explains it near by is proposed
/// to the filter, whose weights then decide.
void Localizer::State::look_for_slips(const Now& now) {
  if (!config.localize.slips || !d.tracked || !filter.odometry() || now.beams.hits == 0) return;
  const Pose motion = relative(now.odometry, *filter.odometry());
  const Pose expected = compose(*d.tracked, motion);
  const double worth = config.search.effective_beams;
  const SlipPrior slip = slip_prior(*d.tracked, now.elapsed_s, d.since_well_m);
  const double here = judge.evidence(now.beams, expected);
  if (worth * (d.monitor.typical() * judge.attainable() - here) < -portable_log64(slip.odds)) return;
  const auto found = near_by().look(now.beams, expected, reach_of(slip));
  if (!found || worth * (judge.evidence(now.beams, found->pose) - here) < -portable_log64(slip.odds)) return;
  const Pose back = inverse(motion);
  filter.propose({compose(found->pose, back), kModeSigma_m, kModeSigma_rad}, kSlipShare, slip);
}

/// Before a scan is weighed: whether there are other places where the robot may be.
void Localizer::State::settle(const Now& now, LocalizerEstimate& out) {
  d.since_search_s += now.elapsed_s;
  const bool under_way = search && search->under_way();
  if (!under_way && search_is_due(now.odometry) && !(d.lost && fits_again(now))) start_search(now);
  go_on_searching(now, out);
  weigh_rivals(now);
  if (!d.settled && !d.lost && config.localize.recover && filter.odometry()) drop_refuted(now);
}

/// Health of the estimate, after a scan was weighed.
void Localizer::State::watch(const Now& now, LocalizerEstimate& out) {
  const PoseEstimate& heaviest = out.filter.cluster;
  const BeamTable& beams = filter.last_beams();
  const double novel = d.novelty.add(now.odometry, now.elapsed_s, beams);
  d.missing.add(beams, novel);
  judge.set_lost(d.missing.share());
  const JudgedPlace here{heaviest.mean, judge.evidence(beams, heaviest.mean), judge.attainable()};
  const WallGeometry walls = wall_geometry(beams, judge.expected_m(), filter.map().resolution_m);
  add(map_error(walls, heaviest.mean.theta_rad, filter.map().resolution_m), out.filter.covariance);
  const double within = probability_within(out.filter.covariance);
  d.last = d.monitor.update({here.evidence, here.attainable, heaviest.weight, novel, within});
  const double moved_m = d.tracked ? distance_m(*d.tracked, heaviest.mean) : 0.0;
  d.tracked = heaviest.mean;
  d.since_well_m = here.fits() ? 0.0 : d.since_well_m + moved_m;
  d.lost = d.last.state == HealthState::lost;
  const bool doubted = std::exchange(d.doubt, d.last.log_odds < 0.0);
  if (d.lost && d.settled) d.settled = false, d.was_settled = true;
  if (!d.lost && d.was_settled) d.settled = true, d.was_settled = false;  // some bad scans, and it fits again
  if (!d.lost && !d.doubt) d.rivals.clear();
  // From where the doubt began: it may have been put somewhere else.
  if ((d.settled && !d.doubt) || (d.doubt && !doubted)) judge.forget();
  if ((!d.settled || d.doubt) && d.rivals.empty()) judge.remember(now.odometry, beams);
  if (d.settled && d.last.log_odds >= kTrusted) d.found = false, d.refuted = 0;
  d.last.probability /= 1.0 + static_cast<double>(d.refuted);
  if (d.settled || !config.localize.recover) return;
  d.last.probability *= kUnsettled;
  if (d.last.state == HealthState::tracking) d.last.state = HealthState::ambiguous;
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

LocalizerEstimate Localizer::step(const Pose& recorded, const Scan& scan) {
  State& s = *state_;
  LocalizerEstimate out;
  const std::optional<OdometryReading> reading = s.filter.prepare_odometry(scan.stamp_s, recorded);
  if (reading && s.filter.counts(reading->pose, scan)) {
    const BeamTable beams = s.filter.beams(scan);
    const Now now{reading->pose, reading->elapsed_s, beams};
    s.settle(now, out);
    if (!s.d.lost || s.d.placed) s.look_for_slips(now);
    out.filter = s.filter.step(recorded, scan);
    if (out.filter.weighted) s.watch(now, out);
  } else {
    out.filter = s.filter.step(recorded, scan);  // nothing moves, nothing is learnt
  }
  out.health = s.d.last;
  if (out.health.state == HealthState::ambiguous) out.modes = find_modes(s.filter.particles(), kLeastMode);
  return out;
}

const ParticleFilter& Localizer::filter() const {
  return state_->filter;
}
std::size_t Localizer::searches() const {
  return state_->d.searches;
}

}  // namespace parloc
