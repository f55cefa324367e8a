// The pose graph over pieces of a path: which of them show the same place, and where they then are.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "common/slam/loops/loop_counts.h"
#include "common/slam/loops/match_pieces.h"
#include "common/slam/loops/pose_graph.h"

namespace parloc {

/// A loop: the robot has gone so far in between.
constexpr double kLeastTravel_m = 8.0;

/// A piece that may show what another shows.
struct Neighbour {
  std::size_t piece;
  double distance_m;
  double off_m;  ///< How far off it may be.
};

/// The nearest, no two next to each other: those show the same.
std::vector<Neighbour> nearest(std::vector<Neighbour> near, std::size_t most);

/// Pieces of the path, one after the other: each is looked for in what is around, and what is left over is
/// distributed before the next.
class PieceGraph {
 public:
  /// All must outlive it. `watch`, told how much of this is done, may be empty.
  PieceGraph(const std::vector<BeamTable>& scans, const ScanChain& chain, ScanMatcher& matcher,
             const std::function<void(double fraction)>& watch);

  const std::vector<Piece>& pieces() const { return piece_; }
  const LoopCounts& counts() const { return counts_; }
  /// By scan: where its piece is, bent between the middles of pieces.
  std::vector<Pose> path() const;
  /// Whether a loop was closed between the two, or close to both.
  bool closed(std::size_t a, std::size_t b) const {
    return closed_.count({std::min(a, b), std::max(a, b)}) > 0;
  }
  double travel_between_m(std::size_t a, std::size_t b) const {
    return std::fabs(chain_.travelled_m[piece_[b].middle] - chain_.travelled_m[piece_[a].middle]);
  }

 private:
  struct Match {
    PoseEdge edge;
    bool used = false;
  };

  Pose step(std::size_t from, std::size_t to) const {
    return relative(chain_.pose[piece_[to].middle], chain_.pose[piece_[from].middle]);
  }
  void add(std::size_t b);
  std::vector<double> distances_by_loops_m(std::size_t b) const;
  std::vector<Neighbour> candidates(std::size_t b) const;
  bool has_rival(const PieceMatcher::Found& match, const std::vector<PieceMatcher::Found>& all,
                 const std::vector<Neighbour>& near) const;
  bool agree(const PoseEdge& p, const PoseEdge& q) const;
  bool take_agreeing(std::size_t first_new);
  bool take_confirmed();
  void take(Match& match);

  const ScanChain& chain_;
  std::vector<Piece> piece_;
  PieceMatcher matcher_;
  std::vector<Pose> pose_;  ///< Of the middles.
  std::vector<PoseEdge> edge_;
  std::vector<Match> match_;
  std::set<std::pair<std::size_t, std::size_t>> closed_;
  LoopCounts counts_;
};

}  // namespace parloc
