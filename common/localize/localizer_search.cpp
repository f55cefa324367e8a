// Where else the robot may be: what a localizer does when it does not know, or doubts.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/localize/localizer_state.h"

namespace parloc {
namespace {

/// Particles are put about a hypothesis with this spread: of the search's last refinement.
constexpr double kFoundSigma_m = 0.07, kFoundSigma_rad = 0.035;
/// No hypothesis gets fewer particles than this share of an equal part: a wrong ranking must be able to turn.
constexpr double kLeastShare = 0.25;
/// Shares of all that the search finds: from here on there is no doubt, and up to here none worth a particle.
constexpr double kNoDoubt = 0.99;
/// Odds of a place that is found late: those found first were what the scans before spoke for.
constexpr double kNewcomer = 0.05;
/// A hypothesis this close to a mode is the same place.
constexpr double kSame_m = 1.0, kSame_rad = 0.5;

/// Work of a slice of the search (search_work.h), 2 to 3 ns each on a core: the longer the time between
/// scans, the more, but always some milliseconds, and at most localize.search_slice.
constexpr double kWorkPer_s = 4e7, kLeastSlice = 2e6, kMillion = 1e6;
constexpr std::int64_t kAllWork = std::numeric_limits<std::int64_t>::max();
constexpr double kSearchEvery_s = 2.0;  ///< Or sooner, if it has moved.

bool same_place(const Pose& a, const Pose& b) {
  return distance_m(a, b) < kSame_m && turn_rad(a, b) < kSame_rad;
}

std::int64_t slice_of(double elapsed_s, double most_millions) {
  const double most = kMillion * most_millions;
  return static_cast<std::int64_t>(std::clamp(kWorkPer_s * elapsed_s, std::min(kLeastSlice, most), most));
}

}  // namespace

namespace {

std::unique_ptr<SlipSearch> make_slip_search(const GridMap& map, const LocalizerConfig& config,
                                             const GlobalSearch& whole) {
  ComputeConfig one = config;
  one.threads = 1;  // less than a millisecond of work: to wake others takes as long
  return std::make_unique<SlipSearch>(map, config.search, one, &whole);
}

}  // namespace

GlobalSearch& Localizer::State::whole_map() {
  if (!search) search = std::make_unique<GlobalSearch>(filter.map(), config.search, config);
  return *search;
}

SlipSearch& Localizer::State::near_by() {
  if (!slips) slips = make_slip_search(filter.map(), config, whole_map());
  return *slips;
}

struct Localizer::PreparedMap::Parts {
  ParticleFilter::PreparedMap filter;
  PlaceEvidence judge;
  std::unique_ptr<GlobalSearch> search;
  std::unique_ptr<SlipSearch> slips;
};
Localizer::PreparedMap::PreparedMap(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Localizer::PreparedMap::PreparedMap(PreparedMap&&) noexcept = default;
Localizer::PreparedMap& Localizer::PreparedMap::operator=(PreparedMap&&) noexcept = default;
Localizer::PreparedMap::~PreparedMap() = default;
const GridMap& Localizer::PreparedMap::map() const {
  return parts_->filter.map();
}

std::vector<double> Localizer::State::reaches_m() const {
  const std::lock_guard lock(reaches_lock);
  return reaches;
}

void Localizer::State::note_reach(double range_max_m) {
  constexpr std::size_t kMostReaches = 8;
  if (reaches.size() == kMostReaches ||
      std::find(reaches.begin(), reaches.end(), range_max_m) != reaches.end())
    return;
  const std::lock_guard lock(reaches_lock);
  reaches.push_back(range_max_m);
}

Localizer::PreparedMap Localizer::prepare_map(const GridMap& map) const {
  const LocalizerConfig& c = state_->config;
  auto parts = std::make_unique<PreparedMap::Parts>(PreparedMap::Parts{
      state_->filter.prepare_map(map), PlaceEvidence(map, c.search.effective_beams), {}, {}});
  if (state_->searches()) {
    parts->search = std::make_unique<GlobalSearch>(map, c.search, c);
    parts->slips = make_slip_search(map, c, *parts->search);
  }
  for (const double range_max_m : state_->reaches_m()) {
    parts->judge.learn(range_max_m);
    if (parts->slips) parts->slips->learn(range_max_m);
  }
  return PreparedMap(std::move(parts));
}

void Localizer::replace_map(PreparedMap prepared) {
  State& s = *state_;
  const std::unique_ptr<PreparedMap::Parts> parts = std::move(prepared.parts_);
  if (parts == nullptr)
    throw Error(ErrorKind::usage, "replace_map: expected a map that this localizer has prepared");
  s.filter.replace_map(std::move(parts->filter));
  parts->judge.go_on_from(std::move(s.judge));
  s.judge = std::move(parts->judge);
  if (s.search && s.search->under_way()) s.d.searched_odometry.reset();  // due again
  s.search = std::move(parts->search);
  s.slips = std::move(parts->slips);
  s.d.rivals.clear();
  s.d.expected.reset();
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
  d.trusted = false;
  d.was_settled = false;
  d.monitor.reset(kFoundLogOdds);
  d.tracked.reset();
  d.rivals.clear();
  d.placed = true;
  d.lost = false;
}

/// Places of a search that the filter does not stand for, with their shares of the belief in them and in what
/// it stands for.
std::vector<JudgedPlace> Localizer::State::newcomers(const std::vector<JudgedPlace>& found,
                                                     const std::vector<Mode>& modes, const Now& now) {
  std::vector<Pose> places;
  for (const Mode& mode : modes) places.push_back(mode.pose);
  for (const JudgedPlace& place : found) {
    const auto known = [&](const Mode& mode) { return same_place(mode.pose, place.pose); };
    if (place.share >= kNoMatter && std::none_of(modes.begin(), modes.end(), known))
      places.push_back(place.pose);
  }
  if (places.size() == modes.size()) return {};
  std::vector<JudgedPlace> judged = judge.judge(places, now.odometry, now.beams);
  double total = 0.0;
  for (std::size_t k = 0; k < judged.size(); ++k)
    total += judged[k].share *= k < modes.size() ? 1.0 : kNewcomer;
  judged.erase(judged.begin(), judged.begin() + static_cast<std::ptrdiff_t>(modes.size()));
  for (JudgedPlace& place : judged) place.share /= total;
  return judged;
}

/// Whether another place explains the scans, too. If so, it gets its share of the particles; if not, and the
/// filter has made up its mind, that is settled.
void Localizer::State::look_for_others(const std::vector<JudgedPlace>& found, const Now& now) {
  const std::vector<Mode> modes = modes_at(now.odometry);
  std::vector<JudgedPlace> others = newcomers(found, modes, now);
  if (others.empty()) {
    d.settled = !found.empty() && !modes.empty() && modes[0].weight >= 1.0 - kNoMatter;
    return;
  }
  std::erase_if(others, [](const JudgedPlace& place) { return place.share < kNoMatter; });
  if (others.empty()) return;  // not settled: there was one
  std::vector<PoseGuess> guesses;
  double elsewhere = 0.0;
  for (const JudgedPlace& place : others) {
    guesses.push_back({place.pose, kFoundSigma_m, kFoundSigma_rad, place.share});
    elsewhere += place.share;
  }
  for (const Mode& mode : modes)
    guesses.push_back({mode.pose, kModeSigma_m, kModeSigma_rad, (1.0 - elsewhere) * mode.weight + 1e-6});
  filter.relocate(guesses, now.odometry);
  d.tracked.reset();
}

/// A slice of the search that is under way, if there is one, and what follows from what it has found.
void Localizer::State::go_on_searching(const Now& now, LocalizerEstimate& out) {
  if (!search || !search->under_way()) return;
  if (d.settled && !d.doubt) return search->cancel();  // some bad scans, and it fits again
  const bool at_once = !d.placed && config.localize.first_search_at_once;
  if (!search->advance(at_once ? kAllWork : slice_of(now.elapsed_s, config.localize.search_slice))) return;
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

}  // namespace parloc
