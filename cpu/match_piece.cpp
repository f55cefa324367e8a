#include "cpu/match_piece.h"

#include <algorithm>
#include <cmath>

#include "common/filter/bind.h"
#include "common/math/portable64.h"
#include "cpu/draft_map.h"

namespace parloc::cpu {
namespace {

// A window is as large as one search can be; a wider reach is several, side by side.
constexpr double kWide_m = 1.0, kWide_rad = 0.4, kNarrow_m = 0.5, kNarrow_rad = 0.2;
constexpr double kMostCells = 20.0;  // of a window's reach
constexpr std::size_t kFewBeams = 200, kBeams = 600, kLeastBeams = 100;
// Places are different ones if so far apart.
constexpr double kApart_m = 0.5, kApart_rad = 0.15;
constexpr std::size_t kMostPlaces = 3;
constexpr float kWorthALook = 0.2f;  // less than the best may a place fit before it is looked at closely
constexpr float kLeastFit = 0.55f;
constexpr float kClearly = 0.08f;  // the best place must fit so much better than the next
// A fit that is so much less could be as good but for chance: some beams more or less.
constexpr double kByChance = 0.05;
// The surface of the fit is looked at in steps of so much, so many to either side: what lets a scan slide
// along a corridor shows within half a metre.
constexpr double kStep_m = 0.1, kStep_rad = 0.02;
constexpr int kSteps = 5, kTurns = 2;
constexpr double kFloor_m = 0.03, kFloor_rad = 0.006;  // of the spread: what a match is worth at best

void add_beam(BeamTable& to, const BeamTable& from, std::size_t m, const Pose& at, float cells_per_m) {
  const SinCos64 turn = portable_sincos64(at.theta_rad);
  const auto c = static_cast<float>(turn.cos), s = static_cast<float>(turn.sin);
  to.end_x.push_back(c * from.end_x[m] - s * from.end_y[m] + static_cast<float>(at.x_m) * cells_per_m);
  to.end_y.push_back(s * from.end_x[m] + c * from.end_y[m] + static_cast<float>(at.y_m) * cells_per_m);
  to.direction_x.push_back(c * from.direction_x[m] - s * from.direction_y[m]);
  to.direction_y.push_back(s * from.direction_x[m] + c * from.direction_y[m]);
  to.range_m.push_back(from.range_m[m]);
  for (auto* unused : {&to.origin_x, &to.origin_y, &to.short_density}) unused->push_back(0.0f);
}

}  // namespace

PieceMatcher::PieceMatcher(const SlamConfig& config, const std::vector<BeamTable>& scans,
                           const ScanChain& chain, const std::vector<Piece>& pieces)
    : config_(config),
      climb_{bind_propose_rules(config).match, {}, bind_propose_rules(config).climb},
      wide_m_(std::min(kWide_m, kMostCells * config.resolution)),
      wide_(bind_search_rules(config, wide_m_, kWide_rad, 0.0)),
      narrow_(bind_search_rules(config, std::min(kNarrow_m, wide_m_), kNarrow_rad, 0.0)),
      scans_(scans),
      chain_(chain),
      pieces_(pieces) {}

/// Hits of all its scans, evenly, as one scan from the piece's middle; of matching's use only, not to draw.
BeamTable PieceMatcher::beams_of(std::size_t piece, std::size_t most) const {
  const Piece& p = pieces_[piece];
  const auto usable = [&](const BeamTable& t, std::size_t m) {
    return t.range_m[m] <= climb_.match.usable_m;
  };
  std::size_t all = 0, seen = 0;
  for (std::size_t k = p.begin; k < p.end; ++k)
    for (std::size_t m = 0; m < scans_[k].hits; ++m) all += usable(scans_[k], m) ? 1 : 0;
  const std::size_t wanted = std::min(all, most);
  BeamTable out;
  for (std::size_t k = p.begin; k < p.end; ++k) {
    const Pose at = relative(chain_.pose[k], chain_.pose[p.middle]);
    for (std::size_t m = 0; m < scans_[k].hits; ++m) {
      if (!usable(scans_[k], m)) continue;
      if (seen * wanted / all != (seen + 1) * wanted / all)
        add_beam(out, scans_[k], m, at, climb_.match.inv_resolution);
      ++seen;
    }
  }
  out.hits = out.count = out.range_m.size();
  return out;
}

/// The best first; of few beams, then those worth it of more.
std::vector<PieceMatcher::Fit> PieceMatcher::best_places(const TileMap& map, std::size_t b, const Pose& guess,
                                                         double reach_m) const {
  const BeamTable few = beams_of(b, kFewBeams), all = beams_of(b, kBeams);
  if (all.hits < kLeastBeams) return {};
  const auto better = [](const Fit& p, const Fit& q) { return p.fit > q.fit; };
  const bool narrow = reach_m <= std::min(kNarrow_m, wide_m_);
  const MatchScanRules search{climb_.match, narrow ? narrow_ : wide_, climb_.climb};
  const int windows = std::max(0, static_cast<int>(std::ceil((reach_m - wide_m_) / (2.0 * wide_m_))));
  std::vector<Fit> places;
  for (int i = -windows; i <= windows; ++i)
    for (int j = -windows; j <= windows; ++j) {
      const Pose start{guess.x_m + 2.0 * wide_m_ * i, guess.y_m + 2.0 * wide_m_ * j, guess.theta_rad};
      const ScanMatch found = match_scan(search, map, bind_beams(few), slam_pose(start));
      places.push_back({pose_of(found.pose), found.fit});
    }
  std::stable_sort(places.begin(), places.end(), better);
  std::vector<Fit> best;
  for (const Fit& place : places) {
    if (place.fit < places[0].fit - kWorthALook || best.size() == kMostPlaces) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const Fit& other) {
      return distance_m(other.pose, place.pose) < kApart_m && turn_rad(place.pose, other.pose) < kApart_rad;
    });
    if (known) continue;
    const ScanMatch found = match_scan(climb_, map, bind_beams(all), slam_pose(place.pose));
    best.push_back({pose_of(found.pose), found.fit});
  }
  std::stable_sort(best.begin(), best.end(), better);
  return best;
}

/// Mean square of how far off the pose may be, from how the fit falls around it: long where the scans slide.
Matrix3 PieceMatcher::spread(const TileMap& map, const BeamTable& beams, const Pose& at) const {
  std::vector<Vector3> offset;
  std::vector<SlamPose> pose;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j)
      for (int turn = -kTurns; turn <= kTurns; ++turn) {
        offset.push_back({{kStep_m * i, kStep_m * j, kStep_rad * turn}});
        const Vector3& d = offset.back();
        pose.push_back(slam_pose({at.x_m + d[0], at.y_m + d[1], wrap64(at.theta_rad + d[2])}));
      }
  const std::vector<float> fit = fits_at(climb_.match, map, bind_beams(beams), pose);
  const double most = *std::max_element(fit.begin(), fit.end());
  Matrix3 sum;
  double weights = 0.0;
  for (std::size_t k = 0; k < fit.size(); ++k) {
    const double weight = portable_exp64((fit[k] - most) / kByChance);
    weights += weight;
    sum = plus_outer(sum, weight, offset[k]);
  }
  Matrix3 covariance = diagonal3(kFloor_m * kFloor_m, kFloor_m * kFloor_m, kFloor_rad * kFloor_rad);
  for (int i = 0; i < 9; ++i) covariance.m[i] += sum.m[i] / weights;
  return covariance;
}

bool PieceMatcher::rivals(const Fit& best, const Fit& other) {
  return other.fit > best.fit - kClearly && distance_m(other.pose, best.pose) > kApart_m;
}

PieceMatcher::Found PieceMatcher::match(std::size_t a, std::size_t b, const Pose& guess,
                                        double reach_m) const {
  DraftMap map(bind_draw_rules(config_), climb_.match);
  const std::size_t first = a > 0 ? a - 1 : a, last = std::min(a + 1, pieces_.size() - 1);
  for (std::size_t k = pieces_[first].begin; k < pieces_[last].end; ++k)
    map.draw(bind_beams(scans_[k]), slam_pose(relative(chain_.pose[k], chain_.pose[pieces_[a].middle])));
  Found found{best_places(map.view(), b, guess, reach_m), std::nullopt};
  if (found.places.empty() || found.places[0].fit < kLeastFit) return found;
  const Fit& best = found.places[0];
  const bool sure = std::none_of(found.places.begin(), found.places.end(),
                                 [&](const Fit& other) { return rivals(best, other); });
  if (sure)
    found.edge = PoseEdge{a, b, best.pose, spread(map.view(), beams_of(b, kFewBeams), best.pose), true};
  return found;
}

}  // namespace parloc::cpu
