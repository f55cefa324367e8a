#include "common/slam/scan_odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/portable64.h"

namespace parloc {
namespace {

// The window around the prediction, and the wider one where nothing fits there: as large as one search can
// be, at several headings.
constexpr double kReach_m = 0.4, kReach_rad = 0.3;
constexpr double kFar_m = 1.0, kFar_rad = 0.4;
constexpr int kFarTurns = 2;  // windows to either side, 2 kFar_rad apart
constexpr double kBias = 0.05;
constexpr float kPull = 2.0f;       // of the climb, to the prediction [1/m^2]
constexpr double kNewSpeed = 0.2;   // part of a step in the speed along the path, which is a mean: corridors
constexpr double kGap_s = 2.0;      // after it, the prediction is worth little
constexpr float kGoodFit = 0.6f;    // of the climb from the prediction: no search is needed
constexpr float kLeastFit = 0.35f;  // below it, a scan does not fit
constexpr float kLeastFarFit = 0.5f;   // the wider the window, the more poses fit by chance
constexpr float kFarGain = 0.15f;      // by which it must fit better there than near, after a gap
constexpr std::size_t kPatience = 10;  // scans that do not fit, before the local map is begun anew
// A key scan after so much path; the local map is begun anew from the last `kKept` when it has `kMost`.
constexpr double kKey_m = 0.25, kKey_rad = 0.2;
constexpr std::size_t kMost = 60, kKept = 30;  // by LiDAR
constexpr double kMostSteps = 2.0;             // that a prediction goes on for: robots stop
constexpr double kShortest_s = 1e-3;           // of a step whose speed is known

}  // namespace

ScanOdometry::ScanOdometry(std::unique_ptr<ScanMatcher> matcher) : matcher_(std::move(matcher)) {
  const MatcherRules& rules = matcher_->rules();
  near_ = bind_search_rules(rules.resolution_m, kReach_m, kReach_rad, kBias);
  far_ = bind_search_rules(rules.resolution_m, kFar_m, kFar_rad, kBias);
  held_climb_ = rules.climb;
  held_climb_.pull = kPull;
}

/// At the speed of the last step. A stamp that goes backwards says nothing: one more step like the last.
Pose ScanOdometry::predicted(double stamp_s) const {
  if (state_.step_s <= 0.0 || state_.unfit_in_a_row >= kPatience / 2) return state_.pose;
  const double time_s = stamp_s - state_.stamp_s;
  const double steps = time_s >= 0.0 ? std::min(time_s / state_.step_s, kMostSteps) : 1.0;
  return compose(state_.pose, along_arc(state_.step, steps));
}

/// How well the scan fits near `pose`, which is then where; 0: it does not. The search is for where the climb
/// alone does not fit well: it would also find the poses that slide along a corridor, back to what is known.
float ScanOdometry::match(const BeamTable& beams, Pose& pose) {
  const Pose start = relative(pose, state_.origin);
  ScanMatch found = matcher_->match({{0, &beams, start, held_climb_, {}}})[0];
  if (found.fit < kGoodFit) {
    const ScanMatch searched = matcher_->match({{0, &beams, start, matcher_->rules().climb, near_}})[0];
    if (searched.fit > found.fit) found = searched;
  }
  if (found.fit < kLeastFit) return 0.0f;
  pose = compose(state_.origin, found.pose);
  return found.fit;
}

/// The same at several headings, and in a wider window.
float ScanOdometry::match_far(const BeamTable& beams, Pose& pose, float least) {
  std::vector<ScanQuery> queries;
  for (int k = -kFarTurns; k <= kFarTurns; ++k) {
    Pose start = relative(pose, state_.origin);
    start.theta_rad = wrap64(start.theta_rad + 2.0 * kFar_rad * k);
    queries.push_back({0, &beams, start, matcher_->rules().climb, far_});
  }
  ScanMatch best;
  for (const ScanMatch& found : matcher_->match(queries))
    if (found.fit > best.fit) best = found;
  if (best.fit < least) return 0.0f;
  pose = compose(state_.origin, best.pose);
  return best.fit;
}

void ScanOdometry::note_step(double stamp_s, const Pose& pose, bool fits) {
  const double time_s = stamp_s - state_.stamp_s;
  if (time_s > kGap_s) state_.step_s = 0.0;
  if (fits && time_s >= kShortest_s && time_s <= kGap_s && state_.unfit_in_a_row == 0) {
    const Pose step = relative(pose, state_.pose);
    const bool mean = state_.step_s > 0.0;
    const Pose before = mean ? along_arc(state_.step, std::min(time_s / state_.step_s, kMostSteps)) : step;
    state_.step = {before.x_m + kNewSpeed * (step.x_m - before.x_m),
                   before.y_m + kNewSpeed * (step.y_m - before.y_m), step.theta_rad};
    state_.step_s = time_s;
  }
  state_.pose = pose;
  state_.stamp_s = stamp_s;
}

bool ScanOdometry::is_key(std::size_t lidar) const {
  const auto last = std::find_if(state_.keys.rbegin(), state_.keys.rend(),
                                 [&](const KeyScan& k) { return k.lidar == lidar; });
  if (last == state_.keys.rend()) return true;  // of another LiDAR, which may look elsewhere
  const Pose moved = relative(state_.pose, last->pose);
  return moved.x_m * moved.x_m + moved.y_m * moved.y_m >= kKey_m * kKey_m ||
         std::fabs(moved.theta_rad) >= kKey_rad;
}

void ScanOdometry::add_key(const BeamTable& beams, std::size_t lidar) {
  std::size_t lidars = lidar + 1;
  for (const KeyScan& k : state_.keys) lidars = std::max(lidars, k.lidar + 1);
  state_.keys.push_back({beams, state_.pose, lidar});
  if (state_.keys.size() > kMost * lidars)
    keep_keys(kKept * lidars);
  else
    matcher_->draw({{0, &beams, relative(state_.pose, state_.origin)}});
}

/// The local map of the last so many; its origin moves along, so that it stays small.
void ScanOdometry::keep_keys(std::size_t kept) {
  std::vector<KeyScan>& keys = state_.keys;
  if (keys.size() > kept) keys.erase(keys.begin(), keys.end() - static_cast<std::ptrdiff_t>(kept));
  state_.origin = state_.pose;
  draw_keys();
}

void ScanOdometry::draw_keys() {
  std::vector<ScanDrawing> drawings;
  for (const KeyScan& k : state_.keys) drawings.push_back({0, &k.beams, relative(k.pose, state_.origin)});
  matcher_->clear();
  matcher_->draw(drawings);
}

Pose ScanOdometry::step(double stamp_s, const BeamTable& beams, std::size_t lidar, bool enough) {
  ScanOdometryState& s = state_;
  ++s.counts.scans;
  if (s.keys.empty()) {
    s.stamp_s = stamp_s;
    if (enough) add_key(beams, lidar);
    s.counts.unfit += enough ? 0 : 1;
    return s.pose;
  }
  Pose pose = predicted(stamp_s);
  const bool gap = stamp_s - s.stamp_s > kGap_s;
  const float near_fit = enough ? match(beams, pose) : 0.0f;
  bool fits = near_fit > 0.0f;
  const float least = std::max(kLeastFarFit, near_fit + kFarGain);
  if (enough && (gap || !fits) && match_far(beams, pose, least) > 0.0f) fits = true, ++s.counts.far;
  note_step(stamp_s, pose, fits);
  s.unfit_in_a_row = fits ? 0 : s.unfit_in_a_row + 1;
  s.counts.unfit += fits ? 0 : 1;
  if (enough && s.unfit_in_a_row >= kPatience) {
    ++s.counts.new_maps;
    s.unfit_in_a_row = 0;
    s.step_s = 0.0;
    keep_keys(0);
  }
  if (s.keys.empty() || (fits && is_key(lidar))) add_key(beams, lidar);
  return s.pose;
}

void ScanOdometry::restore(ScanOdometryState state) {
  state_ = std::move(state);
  draw_keys();
}

}  // namespace parloc
