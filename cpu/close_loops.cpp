#include "common/slam/close_loops.h"

#include <omp.h>

#include <algorithm>

#include "common/filter/bind.h"
#include "cpu/draft_map.h"
#include "cpu/match_scan.h"
#include "cpu/piece_graph.h"

namespace parloc {
namespace {

using cpu::Neighbour, cpu::Piece, cpu::PieceGraph, cpu::ScanChain;

// When the loops are closed, single scans are matched to earlier and later pieces.
constexpr int kRefinements = 2;
constexpr double kNear_m = 3.0;
constexpr std::size_t kPiecesByScan = 3;
constexpr std::size_t kLeastHits = 60;
constexpr float kLeastFit = 0.55f;
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
        if (apart_m < kNear_m && graph.closed(a, b) && graph.way_between_m(a, b) >= cpu::kLeastWay_m)
          near.push_back({a, apart_m, 0.0});
      }
      for (const Neighbour& n : cpu::nearest(std::move(near), kPiecesByScan)) scans[n.piece].push_back(k);
    }
  return scans;
}

/// Single scans matched to pieces, from where they are.
class Refinement {
 public:
  Refinement(const SlamConfig& c, const std::vector<BeamTable>& scans, const ScanChain& chain, int threads)
      : draw_(bind_draw_rules(c)),
        climb_{bind_propose_rules(c).match, {}, bind_propose_rules(c).climb},
        scans_(scans),
        threads_(threads) {
    for (std::size_t k = 1; k < chain.pose.size(); ++k)
      chain_edge_.push_back({k - 1, k, relative(chain.pose[k], chain.pose[k - 1]),
                             cpu::chain_covariance(chain, k - 1, k), false});
  }
  void run(const PieceGraph& graph, std::vector<Pose>& path) const {
    const auto near = scans_near(graph, path);
    std::vector<std::vector<PoseEdge>> found(near.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_)
    for (std::size_t a = 0; a < near.size(); ++a)
      if (!near[a].empty()) found[a] = match(graph.pieces(), a, near[a], path);
    std::vector<PoseEdge> edges = chain_edge_;
    for (const std::vector<PoseEdge>& some : found) edges.insert(edges.end(), some.begin(), some.end());
    relax(path, edges);
  }

 private:
  std::vector<PoseEdge> match(const std::vector<Piece>& pieces, std::size_t a,
                              const std::vector<std::size_t>& near, const std::vector<Pose>& path) const {
    const std::size_t from = pieces[a].middle;
    cpu::DraftMap map(draw_, climb_.match);
    const std::size_t first = a > 0 ? a - 1 : a, last = std::min(a + 1, pieces.size() - 1);
    for (std::size_t k = pieces[first].begin; k < pieces[last].end; ++k)
      map.draw(bind_beams(scans_[k]), cpu::slam_pose(path[k]));
    std::vector<PoseEdge> edges;
    for (const std::size_t k : near) {
      if (scans_[k].hits < kLeastHits) continue;
      const cpu::ScanMatch m = match_scan(climb_, map.view(), bind_beams(scans_[k]), cpu::slam_pose(path[k]));
      if (m.fit >= kLeastFit)
        edges.push_back({from, k, relative(cpu::pose_of(m.pose), path[from]),
                         diagonal3(kScan_m * kScan_m, kScan_m * kScan_m, kScan_rad * kScan_rad), true});
    }
    return edges;
  }

  DrawRules draw_;
  cpu::MatchScanRules climb_;
  const std::vector<BeamTable>& scans_;
  std::vector<PoseEdge> chain_edge_;
  int threads_;
};

}  // namespace

ClosedPath close_loops(const SlamConfig& config, const ScannedPath& way, int threads,
                       const std::function<void(double fraction)>& watch) {
  ClosedPath closed{way.path, {}};
  if (way.path.empty()) return closed;
  const int team = threads > 0 ? threads : omp_get_num_procs();
  // Of the time, about: the chain takes a third, the graph most of the rest.
  const auto part = [&](double from, double to) {
    return [&watch, from, to](double fraction) {
      if (watch) watch(from + (to - from) * fraction);
    };
  };
  const ScanChain chain = cpu::chain_scans(config, way, part(0.0, 0.35));
  const PieceGraph graph(config, way.scans, chain, team, part(0.35, 0.9));
  closed.counts = graph.counts();
  const auto refined = part(0.9, 1.0);
  if (closed.counts.used > 0) {
    closed.path = graph.path();
    const Refinement refinement(config, way.scans, chain, team);
    for (int k = 0; k < kRefinements; ++k) {
      refined(static_cast<double>(k) / kRefinements);
      refinement.run(graph, closed.path);
    }
  }
  refined(1.0);
  for (std::size_t k = 0; k < way.path.size(); ++k)
    closed.counts.most_moved_m =
        std::max(closed.counts.most_moved_m, distance_m(closed.path[k], way.path[k]));
  return closed;
}

SlamCells drawn_map(const SlamConfig& config, const std::vector<BeamTable>& scans,
                    const std::vector<Pose>& path) {
  cpu::DraftMap map(bind_draw_rules(config), bind_propose_rules(config).match);
  for (std::size_t k = 0; k < scans.size(); ++k) map.draw(bind_beams(scans[k]), cpu::slam_pose(path[k]));
  const TileMap drawn = map.view();
  return gather_cells(drawn.span, drawn.table, [&](const std::vector<std::uint32_t>& ids, Tile* to) {
    for (const std::uint32_t id : ids) *to++ = drawn.pool.at(id);
  });
}

}  // namespace parloc
