#include "common/slam/loops/piece_graph.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <queue>

namespace parloc {
namespace {

// How far off the path may be: so much, and a part of the distance between by known loops. Scan matching
// drifts by less than a hundredth; a robot that slips, or a corridor, by more.
constexpr double kOff_m = 0.6, kOffByTravel = 0.03, kMostOff_m = 4.0;
constexpr double kSeen_m = 1.5;        // pieces whose middles are so much farther apart show the same walls
constexpr double kLoop_m = 0.5;        // what a loop adds to the distance between
constexpr std::size_t kMostTried = 4;  // of the earlier pieces by each later one, the nearest
// Matches agree if the chain between them says so: so close, and half of it more for each piece between.
constexpr double kAgree_m = 0.1, kAgree_rad = 0.03;
constexpr std::size_t kAgreeAcross = 4;    // pieces
constexpr std::size_t kOthersToAgree = 2;  // of other pieces each, before any of the matches counts

constexpr std::size_t kAcrossClosed = 4;  // pieces to either side of a loop for which it is closed, too
constexpr double kConfirmed = 3.0;        // times that close to where all loops put it: as good as agreed

std::size_t apart(std::size_t a, std::size_t b) {
  return a > b ? a - b : b - a;
}

bool close_to(const Pose& a, const Pose& b, double factor) {
  return distance_m(a, b) < factor * kAgree_m && turn_rad(a, b) < factor * kAgree_rad;
}

}  // namespace

std::vector<Neighbour> nearest(std::vector<Neighbour> near, std::size_t most) {
  std::stable_sort(near.begin(), near.end(),
                   [](const Neighbour& p, const Neighbour& q) { return p.distance_m < q.distance_m; });
  std::vector<Neighbour> out;
  for (const Neighbour& n : near) {
    const bool beside =
        std::any_of(out.begin(), out.end(), [&](const Neighbour& o) { return apart(o.piece, n.piece) < 2; });
    if (!beside && out.size() < most) out.push_back(n);
  }
  return out;
}

PieceGraph::PieceGraph(const std::vector<BeamTable>& scans, const ScanChain& chain, ScanMatcher& matcher,
                       const std::function<void(double fraction)>& watch)
    : chain_(chain), piece_(cut_in_pieces(chain)), matcher_(scans, chain, piece_, matcher) {
  for (std::size_t b = 0; b < piece_.size(); ++b) {
    add(b);
    if (watch) watch(static_cast<double>(b + 1) / static_cast<double>(piece_.size()));
  }
  while (take_confirmed()) relax(pose_, edge_);
}

void PieceGraph::add(std::size_t b) {
  if (b == 0) {
    pose_.push_back(chain_.pose[piece_[0].middle]);
    return;
  }
  pose_.push_back(compose(pose_.back(), step(b - 1, b)));
  edge_.push_back(
      {b - 1, b, step(b - 1, b), chain_covariance(chain_, piece_[b - 1].middle, piece_[b].middle), false});
  const std::vector<Neighbour> near = candidates(b);
  std::vector<PieceMatcher::Window> windows;
  for (const Neighbour& n : near) windows.push_back({n.piece, relative(pose_[b], pose_[n.piece]), n.off_m});
  const std::vector<PieceMatcher::Found> found = matcher_.match(b, windows);
  const std::size_t before = match_.size();
  for (const PieceMatcher::Found& f : found)
    if (f.edge && !has_rival(f, found, near)) match_.push_back({*f.edge, false});
  counts_.tried += near.size();
  counts_.found += match_.size() - before;
  if (take_agreeing(before)) relax(pose_, edge_);
}

/// From piece b to each: the shortest path over the chain and the loops that are known (Dijkstra).
std::vector<double> PieceGraph::distances_by_loops_m(std::size_t b) const {
  std::vector<std::vector<std::pair<std::size_t, double>>> next(b + 1);
  for (const PoseEdge& e : edge_) {
    const double travel_m = e.may_be_wrong ? kLoop_m : travel_between_m(e.from, e.to);
    next[e.from].push_back({e.to, travel_m});
    next[e.to].push_back({e.from, travel_m});
  }
  std::vector<double> travel_m(b + 1, std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> front;
  travel_m[b] = 0.0;
  front.push({0.0, b});
  while (!front.empty()) {
    const auto [here_m, at] = front.top();
    front.pop();
    if (here_m > travel_m[at]) continue;
    for (const auto& [to, more_m] : next[at])
      if (here_m + more_m < travel_m[to]) front.push({travel_m[to] = here_m + more_m, to});
  }
  return travel_m;
}

std::vector<Neighbour> PieceGraph::candidates(std::size_t b) const {
  const std::vector<double> travel_m = distances_by_loops_m(b);
  std::vector<Neighbour> near;
  for (std::size_t a = 0; a < b && travel_between_m(a, b) >= kLeastTravel_m; ++a) {
    const double off_m = std::min(kMostOff_m, kOff_m + kOffByTravel * travel_m[a]);
    const double apart_m = distance_m(pose_[a], pose_[b]);
    if (apart_m < off_m + kSeen_m) near.push_back({a, apart_m, off_m});
  }
  return nearest(std::move(near), kMostTried);
}

/// Whether the map of another piece close by puts the same piece elsewhere, about as well: what repeats along
/// a corridor may be seen once from each.
bool PieceGraph::has_rival(const PieceMatcher::Found& match, const std::vector<PieceMatcher::Found>& all,
                           const std::vector<Neighbour>& near) const {
  const std::size_t from = match.edge->from;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (near[k].piece == from || apart(near[k].piece, from) > kAgreeAcross) continue;
    for (ScanMatch other : all[k].places) {
      other.pose = compose(step(from, near[k].piece), other.pose);
      if (PieceMatcher::rivals(match.places[0], other)) return true;
    }
  }
  return false;
}

/// Whether two matches of different pieces put them where the path between the pieces does.
bool PieceGraph::agree(const PoseEdge& p, const PoseEdge& q) const {
  if (p.to == q.to || apart(p.to, q.to) > kAgreeAcross) return false;
  const Pose q_from =
      apart(p.from, q.from) <= kAgreeAcross ? step(p.from, q.from) : relative(pose_[q.from], pose_[p.from]);
  const Pose by_q = compose(compose(q_from, q.step), step(q.to, p.to));
  const double factor = 1.0 + 0.5 * static_cast<double>(apart(p.to, q.to));
  return close_to(by_q, p.step, factor);
}

void PieceGraph::take(Match& match) {
  if (match.used) return;
  match.used = true;
  edge_.push_back(match.edge);
  ++counts_.used;
  const std::size_t a = match.edge.from, b = match.edge.to;
  for (std::size_t i = a - std::min(a, kAcrossClosed); i <= a + kAcrossClosed; ++i)
    for (std::size_t j = b - std::min(b, kAcrossClosed); j <= b + kAcrossClosed; ++j)
      closed_.insert({std::min(i, j), std::max(i, j)});
}

/// Of the matches from `first_new` on, those with enough others that agree, and these; whether there are any.
bool PieceGraph::take_agreeing(std::size_t first_new) {
  const std::size_t before = counts_.used;
  for (std::size_t k = first_new; k < match_.size(); ++k) {
    std::vector<std::size_t> group{k};
    std::set<std::size_t> others;
    for (std::size_t l = 0; l < match_.size(); ++l) {
      if (!agree(match_[k].edge, match_[l].edge)) continue;
      group.push_back(l);
      others.insert(match_[l].edge.to);
    }
    if (others.size() < kOthersToAgree) continue;
    for (const std::size_t l : group) take(match_[l]);
  }
  return counts_.used > before;
}

/// Of the matches left over, those that put pieces where all loops together do.
bool PieceGraph::take_confirmed() {
  const std::size_t before = counts_.used;
  for (Match& match : match_) {
    const Pose seen = relative(pose_[match.edge.to], pose_[match.edge.from]);
    if (before > 0 && close_to(seen, match.edge.step, kConfirmed)) take(match);
  }
  return counts_.used > before;
}

std::vector<Pose> PieceGraph::path() const {
  std::vector<Pose> path;
  for (std::size_t r = 0; r < piece_.size(); ++r)
    for (std::size_t k = piece_[r].begin; k < piece_[r].end; ++k) {
      const std::size_t middle = piece_[r].middle;
      const auto seen_from = [&](std::size_t piece) {
        return compose(pose_[piece], relative(chain_.pose[k], chain_.pose[piece_[piece].middle]));
      };
      Pose p = seen_from(r);
      const bool back = k < middle;
      if (back ? r > 0 : r + 1 < piece_.size()) {
        const std::size_t beside = back ? r - 1 : r + 1;
        const Pose q = seen_from(beside);
        const double part =
            static_cast<double>(apart(k, middle)) / static_cast<double>(apart(piece_[beside].middle, middle));
        p = blend(p, q, part);
      }
      path.push_back(p);
    }
  return path;
}

}  // namespace parloc
