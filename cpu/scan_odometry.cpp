#include "common/slam/scan_odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/filter/bind.h"
#include "common/math/portable64.h"
#include "common/slam/slam_backend.h"
#include "cpu/draft_map.h"
#include "cpu/match_scan.h"

namespace parloc {
namespace {

// The window around the prediction, and the wider one where nothing fits there: as large as one search can
// be, at several headings.
constexpr double kReach_m = 0.4, kReach_rad = 0.3;
constexpr double kFar_m = 1.0, kFar_rad = 0.4;
constexpr int kFarTurns = 2;  // windows to either side, 2 kFar_rad apart
constexpr double kBias = 0.05;
constexpr float kPull = 2.0f;         // of the climb, to the prediction [1/m^2]
constexpr double kNewSpeed = 0.2;     // part of a step in the speed along the way, which is a mean: corridors
constexpr double kGap_s = 2.0;        // after it, the prediction is worth little
constexpr float kGoodFit = 0.6f;      // of the climb from the prediction: no search is needed
constexpr float kLeastFit = 0.35f;    // below it, a scan does not fit
constexpr float kLeastFarFit = 0.5f;  // the wider the window, the more poses fit by chance
constexpr float kFarGain = 0.15f;     // by which it must fit better there than near, after a gap
constexpr std::size_t kPatience = 10;  // scans that do not fit, before the local map is begun anew
// A key scan after so much way; the local map is begun anew from the last `kKept` when it has `kMost`.
constexpr double kKey_m = 0.25, kKey_rad = 0.2;
constexpr std::size_t kMost = 60, kKept = 30;  // by LiDAR
constexpr double kMostSteps = 2.0;             // that a prediction goes on for: robots stop
constexpr double kShortest_s = 1e-3;           // of a step whose speed is known

}  // namespace

struct ScanOdometry::Matcher {
  explicit Matcher(const SlamConfig& c)
      : near{bind_propose_rules(c).match, bind_search_rules(c, kReach_m, kReach_rad, kBias),
             bind_propose_rules(c).climb},
        far{near.match, bind_search_rules(c, kFar_m, kFar_rad, kBias), near.climb},
        climb{near.match, {}, {near.climb.step_xy, near.climb.step_theta, near.climb.halvings, kPull}},
        map(bind_draw_rules(c), near.match) {}

  Pose predicted(double stamp_s) const;
  float match(const BeamTable& beams, Pose& pose);
  float match_far(const BeamTable& beams, Pose& pose, float least);
  void note_step(double stamp_s, const Pose& pose, bool fits);
  bool is_key(std::size_t lidar) const;
  void add_key(const BeamTable& beams, std::size_t lidar);
  void draw_keys(std::size_t kept);

  cpu::MatchScanRules near, far, climb;
  cpu::DraftMap map;
  ScanOdometryState s;
};

/// At the speed of the last step. A stamp that goes backwards says nothing: one more step like the last.
Pose ScanOdometry::Matcher::predicted(double stamp_s) const {
  if (s.step_s <= 0.0 || s.unfit_in_a_row >= kPatience / 2) return s.pose;
  const double time_s = stamp_s - s.stamp_s;
  const double steps = time_s >= 0.0 ? std::min(time_s / s.step_s, kMostSteps) : 1.0;
  return compose(s.pose, along_arc(s.step, steps));
}

/// How well the scan fits near `pose`, which is then where; 0: it does not. The search is for where the climb
/// alone does not fit well: it would also find the poses that slide along a corridor, back to what is known.
float ScanOdometry::Matcher::match(const BeamTable& beams, Pose& pose) {
  const SlamPose start = cpu::slam_pose(relative(pose, s.origin));
  cpu::ScanMatch found = cpu::match_scan(climb, map.view(), bind_beams(beams), start);
  if (found.fit < kGoodFit) {
    const cpu::ScanMatch searched = cpu::match_scan(near, map.view(), bind_beams(beams), start);
    if (searched.fit > found.fit) found = searched;
  }
  if (found.fit < kLeastFit) return 0.0f;
  pose = compose(s.origin, cpu::pose_of(found.pose));
  return found.fit;
}

float ScanOdometry::Matcher::match_far(const BeamTable& beams, Pose& pose, float least) {
  cpu::ScanMatch best;
  for (int k = -kFarTurns; k <= kFarTurns; ++k) {
    Pose start = relative(pose, s.origin);
    start.theta_rad = wrap64(start.theta_rad + 2.0 * kFar_rad * k);
    const cpu::ScanMatch found = cpu::match_scan(far, map.view(), bind_beams(beams), cpu::slam_pose(start));
    if (found.fit > best.fit) best = found;
  }
  if (best.fit < least) return 0.0f;
  pose = compose(s.origin, cpu::pose_of(best.pose));
  return best.fit;
}

void ScanOdometry::Matcher::note_step(double stamp_s, const Pose& pose, bool fits) {
  const double time_s = stamp_s - s.stamp_s;
  if (time_s > kGap_s) s.step_s = 0.0;
  if (fits && time_s >= kShortest_s && time_s <= kGap_s && s.unfit_in_a_row == 0) {
    const Pose step = relative(pose, s.pose);
    const bool mean = s.step_s > 0.0;
    const Pose before = mean ? along_arc(s.step, std::min(time_s / s.step_s, kMostSteps)) : step;
    s.step = {before.x_m + kNewSpeed * (step.x_m - before.x_m),
              before.y_m + kNewSpeed * (step.y_m - before.y_m), step.theta_rad};
    s.step_s = time_s;
  }
  s.pose = pose;
  s.stamp_s = stamp_s;
}

bool ScanOdometry::Matcher::is_key(std::size_t lidar) const {
  const auto last =
      std::find_if(s.keys.rbegin(), s.keys.rend(), [&](const KeyScan& k) { return k.lidar == lidar; });
  if (last == s.keys.rend()) return true;  // of another LiDAR, which may look elsewhere
  const Pose moved = relative(s.pose, last->pose);
  return moved.x_m * moved.x_m + moved.y_m * moved.y_m >= kKey_m * kKey_m ||
         std::fabs(moved.theta_rad) >= kKey_rad;
}

void ScanOdometry::Matcher::add_key(const BeamTable& beams, std::size_t lidar) {
  std::size_t lidars = lidar + 1;
  for (const KeyScan& k : s.keys) lidars = std::max(lidars, k.lidar + 1);
  s.keys.push_back({beams, s.pose, lidar});
  if (s.keys.size() > kMost * lidars)
    draw_keys(kKept * lidars);
  else
    map.draw(bind_beams(beams), cpu::slam_pose(relative(s.pose, s.origin)));
}

/// The local map of the last so many; its origin moves along, so that it stays small.
void ScanOdometry::Matcher::draw_keys(std::size_t kept) {
  if (s.keys.size() > kept) s.keys.erase(s.keys.begin(), s.keys.end() - static_cast<std::ptrdiff_t>(kept));
  s.origin = s.pose;
  map.clear();
  for (const KeyScan& k : s.keys) map.draw(bind_beams(k.beams), cpu::slam_pose(relative(k.pose, s.origin)));
}

ScanOdometry::ScanOdometry(const SlamConfig& config) : matcher_(std::make_unique<Matcher>(config)) {}
ScanOdometry::~ScanOdometry() = default;
ScanOdometry::ScanOdometry(ScanOdometry&&) noexcept = default;

Pose ScanOdometry::step(double stamp_s, const BeamTable& beams, std::size_t lidar, bool enough) {
  Matcher& m = *matcher_;
  ScanOdometryState& s = m.s;
  ++s.counts.scans;
  if (s.keys.empty()) {
    s.stamp_s = stamp_s;
    if (enough) m.add_key(beams, lidar);
    s.counts.unfit += enough ? 0 : 1;
    return s.pose;
  }
  Pose pose = m.predicted(stamp_s);
  const bool gap = stamp_s - s.stamp_s > kGap_s;
  const float near_fit = enough ? m.match(beams, pose) : 0.0f;
  bool fits = near_fit > 0.0f;
  const float least = std::max(kLeastFarFit, near_fit + kFarGain);
  if (enough && (gap || !fits) && m.match_far(beams, pose, least) > 0.0f) fits = true, ++s.counts.far;
  m.note_step(stamp_s, pose, fits);
  s.unfit_in_a_row = fits ? 0 : s.unfit_in_a_row + 1;
  s.counts.unfit += fits ? 0 : 1;
  if (enough && s.unfit_in_a_row >= kPatience) {
    ++s.counts.new_maps;
    s.unfit_in_a_row = 0;
    s.step_s = 0.0;
    m.draw_keys(0);
  }
  if (s.keys.empty() || (fits && m.is_key(lidar))) m.add_key(beams, lidar);
  return s.pose;
}

const ScanOdometryState& ScanOdometry::state() const {
  return matcher_->s;
}

void ScanOdometry::restore(ScanOdometryState state) {
  Matcher& m = *matcher_;
  m.s = std::move(state);
  m.map.clear();
  for (const KeyScan& k : m.s.keys)
    m.map.draw(bind_beams(k.beams), cpu::slam_pose(relative(k.pose, m.s.origin)));
}

}  // namespace parloc
