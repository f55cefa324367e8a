#include "common/slam/loops/match_pieces.h"

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

// A window is as large as one search can be; a wider reach is several, side by side.
constexpr double kWide_m = 1.0, kWide_rad = 0.4, kNarrow_m = 0.5, kNarrow_rad = 0.2;
constexpr double kMostWindowCells = 20.0;  // of a window's reach
constexpr std::size_t kFewBeams = 200, kBeams = 600, kLeastBeams = 100;
// Places are different ones if so far apart.
constexpr double kApart_m = 0.5, kApart_rad = 0.15;
constexpr std::size_t kMostPlaces = 3;
constexpr float kWorthALook = 0.2f;  // less than the best may a place fit before it is looked at closely
constexpr float kLeastPlaceFit = 0.55f;
constexpr float kClearly = 0.08f;  // the best place must fit so much better than the next
// A fit that is so much less could be as good but for chance: some beams more or less.
constexpr double kByChance = 0.05;
// The surface of the fit is looked at in steps of so much, so many to either side: what lets a scan slide
// along a corridor shows within half a metre.
constexpr double kLookStep_m = 0.1, kLookStep_rad = 0.02;
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

bool better(const ScanMatch& p, const ScanMatch& q) {
  return p.fit > q.fit;
}

/// Of `places`, the best first, the next one from `at` on that is worth a closer look and none of `known`.
const ScanMatch* next_place(const std::vector<ScanMatch>& places, std::size_t& at,
                            const std::vector<ScanMatch>& known) {
  while (at < places.size() && places[at].fit >= places[0].fit - kWorthALook && known.size() < kMostPlaces) {
    const ScanMatch& place = places[at++];
    if (std::none_of(known.begin(), known.end(), [&](const ScanMatch& other) {
          return distance_m(other.pose, place.pose) < kApart_m &&
                 turn_rad(place.pose, other.pose) < kApart_rad;
        }))
      return &place;
  }
  return nullptr;
}

/// The surface of the fit is looked at there, seen from the best pose.
std::vector<Vector3> offsets_around() {
  std::vector<Vector3> offsets;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j)
      for (int turn = -kTurns; turn <= kTurns; ++turn)
        offsets.push_back({{kLookStep_m * i, kLookStep_m * j, kLookStep_rad * turn}});
  return offsets;
}

/// Mean square of how far off the pose may be, from how the fit falls around it: long where the scans slide.
/// `fit`: at each of the offsets.
Matrix3 spread(const std::vector<Vector3>& offsets, const ScanMatch* fit) {
  const double most = std::max_element(fit, fit + offsets.size(), [](const ScanMatch& p, const ScanMatch& q) {
                        return p.fit < q.fit;
                      })->fit;
  Matrix3 sum;
  double weights = 0.0;
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    const double weight = portable_exp64((fit[k].fit - most) / kByChance);
    weights += weight;
    sum = plus_outer(sum, weight, offsets[k]);
  }
  Matrix3 covariance = diagonal3(kFloor_m * kFloor_m, kFloor_m * kFloor_m, kFloor_rad * kFloor_rad);
  for (int i = 0; i < 9; ++i) covariance.m[i] += sum.m[i] / weights;
  return covariance;
}

}  // namespace

PieceMatcher::PieceMatcher(const std::vector<BeamTable>& scans, const ScanChain& chain,
                           const std::vector<Piece>& pieces, ScanMatcher& matcher)
    : scans_(scans), chain_(chain), pieces_(pieces), matcher_(matcher) {
  const double resolution_m = matcher.rules().resolution_m;
  wide_m_ = std::min(kWide_m, kMostWindowCells * resolution_m);
  wide_ = bind_search_rules(resolution_m, wide_m_, kWide_rad, 0.0);
  narrow_ = bind_search_rules(resolution_m, std::min(kNarrow_m, wide_m_), kNarrow_rad, 0.0);
}

/// Hits of all its scans, evenly, as one scan from the piece's middle; of matching's use only, not to draw.
BeamTable PieceMatcher::beams_of(std::size_t piece, std::size_t most) const {
  const Piece& p = pieces_[piece];
  const MatchRules& match = matcher_.rules().match;
  const auto usable = [&](const BeamTable& t, std::size_t m) { return t.range_m[m] <= match.usable_m; };
  std::size_t all = 0, seen = 0;
  for (std::size_t k = p.begin; k < p.end; ++k)
    all += count_matched(scans_[k].range_m.data(), scans_[k].hits, match);
  const std::size_t wanted = std::min(all, most);
  BeamTable out;
  for (std::size_t k = p.begin; k < p.end; ++k) {
    const Pose at = relative(chain_.pose[k], chain_.pose[p.middle]);
    for (std::size_t m = 0; m < scans_[k].hits; ++m) {
      if (!usable(scans_[k], m)) continue;
      if (seen * wanted / all != (seen + 1) * wanted / all)
        add_beam(out, scans_[k], m, at, match.inv_resolution);
      ++seen;
    }
  }
  out.hits = out.count = out.range_m.size();
  return out;
}

/// By window, the map of the piece that it is seen from, in that piece's frame.
void PieceMatcher::draw_maps(const std::vector<Window>& windows) const {
  matcher_.clear();
  std::vector<ScanDrawing> drawings;
  for (std::size_t m = 0; m < windows.size(); ++m) {
    const Piece around = with_neighbours(pieces_, windows[m].from);
    for (std::size_t k = around.begin; k < around.end; ++k)
      drawings.push_back({m, &scans_[k], relative(chain_.pose[k], chain_.pose[around.middle])});
  }
  matcher_.draw(drawings);
}

/// Adds to each map's places.
void PieceMatcher::ask(const std::vector<ScanQuery>& queries, std::vector<Found>& found) const {
  const std::vector<ScanMatch> matches = matcher_.match(queries);
  for (std::size_t k = 0; k < queries.size(); ++k) found[queries[k].map].places.push_back(matches[k]);
}

/// A reach that is wider than one search can be is several, side by side.
void PieceMatcher::search(const std::vector<Window>& windows, const BeamTable& beams,
                          std::vector<Found>& found) const {
  std::vector<ScanQuery> queries;
  for (std::size_t m = 0; m < windows.size(); ++m) {
    const auto& [from, guess, reach_m] = windows[m];
    const SearchRules& rules = reach_m <= std::min(kNarrow_m, wide_m_) ? narrow_ : wide_;
    const int beside = std::max(0, static_cast<int>(std::ceil((reach_m - wide_m_) / (2.0 * wide_m_))));
    for (int i = -beside; i <= beside; ++i)
      for (int j = -beside; j <= beside; ++j) {
        const Pose start{guess.x_m + 2.0 * wide_m_ * i, guess.y_m + 2.0 * wide_m_ * j, guess.theta_rad};
        queries.push_back({m, &beams, start, matcher_.rules().climb, rules});
      }
  }
  ask(queries, found);
  for (Found& f : found) std::stable_sort(f.places.begin(), f.places.end(), better);
}

/// Looks closely at the places that are worth it; the others are forgotten.
void PieceMatcher::climb(const BeamTable& beams, std::vector<Found>& found) const {
  std::vector<Found> tried(found.size());
  tried.swap(found);
  std::vector<std::size_t> at(found.size(), 0);
  std::vector<ScanQuery> queries;
  do {
    queries.clear();
    for (std::size_t m = 0; m < found.size(); ++m)
      if (const ScanMatch* place = next_place(tried[m].places, at[m], found[m].places))
        queries.push_back({m, &beams, place->pose, matcher_.rules().climb, {}});
    ask(queries, found);
  } while (!queries.empty());
  for (Found& f : found) std::stable_sort(f.places.begin(), f.places.end(), better);
}

/// Where a piece was found, and in one place only.
void PieceMatcher::add_edges(const std::vector<Window>& windows, std::size_t b, const BeamTable& beams,
                             std::vector<Found>& found) const {
  const std::vector<Vector3> offsets = offsets_around();
  std::vector<ScanQuery> queries;
  for (std::size_t m = 0; m < found.size(); ++m) {
    const std::vector<ScanMatch>& places = found[m].places;
    if (places.empty() || places[0].fit < kLeastPlaceFit ||
        std::any_of(places.begin(), places.end(), [&](const ScanMatch& p) { return rivals(places[0], p); }))
      continue;
    const Pose& at = places[0].pose;
    found[m].edge = PoseEdge{windows[m].from, b, at, {}, true};
    for (const Vector3& d : offsets)
      queries.push_back({m, &beams, {at.x_m + d[0], at.y_m + d[1], wrap64(at.theta_rad + d[2])}, {}, {}});
  }
  const std::vector<ScanMatch> fits = matcher_.match(queries);
  for (std::size_t k = 0; k < queries.size(); k += offsets.size())
    found[queries[k].map].edge->covariance = spread(offsets, &fits[k]);
}

bool PieceMatcher::rivals(const ScanMatch& best, const ScanMatch& other) {
  return other.fit > best.fit - kClearly && distance_m(other.pose, best.pose) > kApart_m;
}

std::vector<PieceMatcher::Found> PieceMatcher::match(std::size_t b,
                                                     const std::vector<Window>& windows) const {
  std::vector<Found> found(windows.size());
  const BeamTable few = beams_of(b, kFewBeams), all = beams_of(b, kBeams);
  if (windows.empty() || all.hits < kLeastBeams) return found;
  draw_maps(windows);
  search(windows, few, found);
  climb(all, found);
  add_edges(windows, b, few, found);
  return found;
}

}  // namespace parloc
