#include "common/slam/loops/close_loops.h"

#include <algorithm>

#include "common/slam/loops/piece_graph.h"

namespace parloc {
namespace {

// When the loops are closed, single scans are matched to earlier and later pieces.
constexpr int kRefinements = 2;
constexpr double kNear_m = 3.0;
constexpr std::size_t kPiecesByScan = 3;
constexpr std::size_t kMapsAtOnce = 16;  // of pieces
constexpr std::size_t kLeastHits = 60;
constexpr float kLeastScanFit = 0.55f;
constexpr double kScan_m = 0.03, kScan_rad = 0.006;

/// By piece: the scans that are to be matched to it, where loops are closed.
std::vector<std::vector<std::size_t>> scans_near(const PieceGraph& graph, const std::vector<Pose>& path) {
  const std::vector<Piece>& pieces = graph.pieces();
  std::vector<std::vector<std::size_t>> scans(pieces.size());
  for (std::size_t b = 0; b < pieces.size(); ++b)
    for (std::size_t k = pieces[b].begin; k < pieces[b].end; ++k) {
      std::vector<Neighbour> near;
      for (std::size_t a = 0; a < pieces.size(); ++a) {
        const double apart_m = distance_m(path[k], path[pieces[a].middle]);
        if (apart_m < kNear_m && graph.closed(a, b) && graph.travel_between_m(a, b) >= kLeastTravel_m)
          near.push_back({a, apart_m, 0.0});
      }
      for (const Neighbour& n : nearest(std::move(near), kPiecesByScan)) scans[n.piece].push_back(k);
    }
  return scans;
}

/// Single scans matched to pieces, from where they are.
class Refinement {
 public:
  Refinement(const std::vector<BeamTable>& scans, const ScanChain& chain, ScanMatcher& matcher)
      : scans_(scans), matcher_(matcher) {
    for (std::size_t k = 1; k < chain.pose.size(); ++k)
      chain_edge_.push_back(
          {k - 1, k, relative(chain.pose[k], chain.pose[k - 1]), chain_covariance(chain, k - 1, k), false});
  }
  void run(const PieceGraph& graph, std::vector<Pose>& path) const {
    const auto near = scans_near(graph, path);
    std::vector<PoseEdge> edges = chain_edge_;
    std::vector<std::size_t> some;
    for (std::size_t a = 0; a < near.size(); ++a) {
      if (!near[a].empty()) some.push_back(a);
      if (some.size() < kMapsAtOnce && a + 1 < near.size()) continue;
      add_matches(graph.pieces(), some, near, path, edges);
      some.clear();
    }
    relax(path, edges);
  }

 private:
  /// Of the scans near some of the pieces.
  void add_matches(const std::vector<Piece>& pieces, const std::vector<std::size_t>& some,
                   const std::vector<std::vector<std::size_t>>& near, const std::vector<Pose>& path,
                   std::vector<PoseEdge>& edges) const {
    std::vector<ScanDrawing> drawings;
    std::vector<ScanQuery> queries;
    std::vector<std::size_t> scan;  // by query
    for (std::size_t m = 0; m < some.size(); ++m) {
      const Piece around = with_neighbours(pieces, some[m]);
      for (std::size_t k = around.begin; k < around.end; ++k) drawings.push_back({m, &scans_[k], path[k]});
      for (const std::size_t k : near[some[m]]) {
        if (scans_[k].hits < kLeastHits) continue;
        queries.push_back({m, &scans_[k], path[k], matcher_.rules().climb, {}});
        scan.push_back(k);
      }
    }
    matcher_.clear();
    matcher_.draw(drawings);
    const std::vector<ScanMatch> matches = matcher_.match(queries);
    for (std::size_t q = 0; q < matches.size(); ++q) {
      if (matches[q].fit < kLeastScanFit) continue;
      const std::size_t from = pieces[some[queries[q].map]].middle;
      edges.push_back({from, scan[q], relative(matches[q].pose, path[from]),
                       diagonal3(kScan_m * kScan_m, kScan_m * kScan_m, kScan_rad * kScan_rad), true});
    }
  }

  const std::vector<BeamTable>& scans_;
  ScanMatcher& matcher_;
  std::vector<PoseEdge> chain_edge_;
};

}  // namespace

ClosedPath close_loops(const ScannedPath& scanned, ScanMatcher& matcher,
                       const std::function<void(double fraction)>& watch) {
  ClosedPath closed{scanned.path, {}};
  if (scanned.path.empty()) return closed;
  // Of the time, about: the chain takes a third, the graph most of the rest.
  const auto part = [&](double from, double to) {
    return [&watch, from, to](double fraction) {
      if (watch) watch(from + (to - from) * fraction);
    };
  };
  const ScanChain chain = chain_scans(scanned, matcher, part(0.0, 0.35));
  const PieceGraph graph(scanned.scans, chain, matcher, part(0.35, 0.9));
  closed.counts = graph.counts();
  const auto refined = part(0.9, 1.0);
  if (closed.counts.used > 0) {
    closed.path = graph.path();
    const Refinement refinement(scanned.scans, chain, matcher);
    for (int k = 0; k < kRefinements; ++k) {
      refined(static_cast<double>(k) / kRefinements);
      refinement.run(graph, closed.path);
    }
  }
  refined(1.0);
  for (std::size_t k = 0; k < scanned.path.size(); ++k)
    closed.counts.most_moved_m =
        std::max(closed.counts.most_moved_m, distance_m(closed.path[k], scanned.path[k]));
  return closed;
}

SlamCells drawn_map(const std::vector<BeamTable>& scans, const std::vector<Pose>& path,
                    ScanMatcher& matcher) {
  std::vector<ScanDrawing> drawings;
  for (std::size_t k = 0; k < scans.size(); ++k) drawings.push_back({0, &scans[k], path[k]});
  matcher.clear();
  matcher.draw(drawings);
  return matcher.cells(0);
}

}  // namespace parloc
