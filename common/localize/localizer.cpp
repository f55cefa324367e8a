#include "common/localize/localizer.h"

#include <utility>

#include "common/error.h"
#include "common/localize/localizer_state.h"
#include "common/localize/map_error.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// What the probability is worth as long as there may be a rival elsewhere.
constexpr double kUnsettled = 0.7;
/// A start that was given is believed, about [nat].
constexpr double kGivenLogOdds = 2.0;
/// A place that a search has chosen has shown itself by so much [nat], with a scan that reaches such a share
/// of what is attainable.
constexpr double kTrusted = 5.0, kShows = 0.6;
constexpr double kSlipShare = 0.25;  ///< Of the particles, for what is found near by.
/// So little changes what a scan says by less than its own noise.
constexpr double kAsExpected_m = 0.03, kAsExpected_rad = 0.01;

}  // namespace

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
  started = true;
}

/// By somebody who sees the robot.
void Localizer::State::told(bool is_settled, const PoseEstimate& where) {
  Drive before = std::move(d);
  begin(false, is_settled, {});
  d.novelty = before.novelty;
  d.missing = std::move(before.missing);
  d.searches = before.searches;
  judge.set_lost(d.missing.share());
  d.given = where;
  d.given_s = before.given_s;
}

/// If the scan fits the prediction badly, the wheels may have slipped: what explains it near by is proposed
/// to the filter, whose weights then decide.
void Localizer::State::look_for_slips(const Now& now) {
  d.expected.reset();
  if (!config.localize.slips || !d.tracked || !filter.odometry() || now.beams.hits == 0) return;
  const Pose motion = relative(now.odometry, *filter.odometry());
  const Pose expected = compose(*d.tracked, motion);
  const double worth = config.search.effective_beams;
  const SlipPrior slip = slip_prior(*d.tracked, now.elapsed_s, d.since_well_m, d.trusted ? d.unexplained : 0);
  const double here = judge.evidence(now.beams, expected);
  if (worth * (d.monitor.typical() * judge.attainable() - here) < -portable_log64(slip.odds)) {
    d.expected = JudgedPlace{expected, here, judge.attainable()};
    d.unexplained = 0;
    return;
  }
  const auto found = near_by().look(now.beams, expected, reach_of(slip));
  const bool far = std::exchange(d.unexplained, d.unexplained + 1) > 0;
  if (!found) return;
  const double there = judge.evidence(now.beams, found->pose);
  if (worth * (there - here) < -portable_log64(slip.odds)) return;
  if (far && there < d.monitor.typical() * judge.attainable()) return;  // of many places one looks alike
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

/// What the scan says of the estimate. Where that is where the robot was expected, it has been asked already.
JudgedPlace Localizer::State::judge_estimate(const BeamTable& beams, const Pose& pose) {
  const bool as_expected = d.expected && judge.expected_m().size() == beams.count &&
                           distance_m(d.expected->pose, pose) < kAsExpected_m &&
                           turn_rad(d.expected->pose, pose) < kAsExpected_rad;
  if (as_expected) return *d.expected;
  return {pose, judge.evidence(beams, pose), judge.attainable()};
}

/// Health of the estimate, after a scan was weighed.
void Localizer::State::watch(const Now& now, LocalizerEstimate& out) {
  const PoseEstimate& heaviest = out.filter.cluster;
  const BeamTable& beams = filter.last_beams();
  const double novel = d.novelty.add(now.odometry, now.elapsed_s, beams);
  d.missing.add(beams, novel);
  judge.set_lost(d.missing.share());
  const JudgedPlace here = judge_estimate(beams, heaviest.mean);
  const WallGeometry walls = wall_geometry(beams, judge.expected_m(), filter.map().resolution_m);
  add_map_error(walls, heaviest.mean.theta_rad, filter.map().resolution_m, out.filter.covariance);
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
  const bool shows = d.settled && d.last.log_odds >= kTrusted && here.evidence >= kShows * here.attainable;
  if (shows) d.found = false, d.refuted = 0;
  d.trusted = shows || (d.trusted && !d.lost);
  d.last.probability /= 1.0 + static_cast<double>(d.refuted);
  if (d.refuted > 0 && d.last.state == HealthState::tracking) d.last.state = HealthState::ambiguous;
  if (d.settled || !config.localize.recover) return;
  d.last.probability *= kUnsettled;
  if (d.last.state == HealthState::tracking) d.last.state = HealthState::ambiguous;
}

Localizer::Localizer(const LocalizerConfig& config, const GridMap& map)
    : state_(std::make_unique<State>(config, map)) {
  validate(config.search);
  if (state_->searches()) (void)state_->near_by();  // not while it drives
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

void Localizer::start_at(const Pose& pose_in_map, double sigma_x_m, double sigma_y_m,
                         double sigma_theta_rad) {
  state_->filter.start_at(pose_in_map, sigma_x_m, sigma_y_m, sigma_theta_rad);
  state_->begin(false, true, {});
}

void Localizer::start_at(const Pose& pose_in_map, const Covariance& covariance) {
  state_->filter.start_at(pose_in_map, covariance);
  state_->begin(false, true, {});
}

void Localizer::relocate(const Pose& pose_in_map, const Covariance& covariance) {
  state_->filter.relocate(pose_in_map, covariance);
  state_->told(true, {pose_in_map, covariance, 1.0, 1.0});
}

void Localizer::relocate(const std::vector<PoseGuess>& guesses) {
  state_->filter.relocate(guesses);
  const PoseGuess& first = guesses.front();
  state_->told(
      guesses.size() == 1,
      {first.pose, covariance_of(first.sigma_xy_m, first.sigma_xy_m, first.sigma_theta_rad), 1.0, 1.0});
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

void Localizer::weigh_next() {
  state_->filter.weigh_next();
}

LocalizerEstimate Localizer::step(const Pose& recorded, const Scan& scan) {
  State& s = *state_;
  s.expect_takes(scan, recorded);
  if (s.filter.refuses(scan)) return s.step(std::nullopt, recorded, scan);
  return s.step(s.filter.prepare_odometry(scan.stamp_s, recorded), recorded, scan);
}

LocalizerEstimate Localizer::step(const Scan& scan) {
  State& s = *state_;
  s.expect_takes(scan, {});
  if (s.filter.refuses(scan)) return s.step(std::nullopt, {}, scan);
  return s.step(s.filter.prepare_odometry(scan.stamp_s), {}, scan);
}

/// Before anything has changed.
void Localizer::State::expect_takes(const Scan& scan, const Pose& recorded) const {
  if (!started) throw Error(ErrorKind::usage, "a step before a start: call start_at or start_anywhere first");
  if (is_finite(recorded)) filter.check(scan);
}

LocalizerEstimate Localizer::State::step(const std::optional<OdometryReading>& reading, const Pose& recorded,
                                         const Scan& scan) {
  LocalizerEstimate out;
  const bool counts = reading && filter.counts(reading->pose, scan);
  // A robot that stands until it knows where it is would not find out.
  const bool looks_for_start = reading && !d.placed && search && search->under_way();
  if (counts || looks_for_start) {
    const BeamTable beams = filter.beams(scan);
    note_reach(static_cast<double>(beams.range_max_m));
    const Now now{reading->pose, reading->elapsed_s, beams};
    settle(now, out);
    if (!d.lost || d.placed) look_for_slips(now);
    out.filter = filter.step(recorded, scan);
    if (out.filter.weighted) watch(now, out);
  } else {
    out.filter = filter.step(recorded, scan);  // nothing is weighed, nothing is learnt
  }
  if (!counts && !out.filter.weighted && d.given_s) out.filter.covariance = d.given.covariance;
  if (reading) {
    const PoseEstimate& heaviest = out.filter.cluster;
    d.given = {out.filter.pose, out.filter.covariance, heaviest.weight, heaviest.heading_resultant};
    d.given_s = out.filter.stamp_s;
  }
  out.health = d.last;
  if (out.health.state == HealthState::ambiguous) out.modes = find_modes(filter.particles(), kLeastMode);
  return out;
}

PoseEstimate Localizer::predict(double stamp_s) const {
  const State& s = *state_;
  if (!s.d.given_s) throw Error(ErrorKind::usage, "predict before the first step: call step first");
  return s.filter.predict_from(s.d.given, *s.d.given_s, stamp_s);
}

const ParticleFilter& Localizer::filter() const {
  return state_->filter;
}
std::size_t Localizer::searches() const {
  return state_->d.searches;
}

}  // namespace parloc
