// A piece of the way against the map of another: several scans at once, in a window as wide as the way
// between is uncertain.
#pragma once

#include <optional>
#include <vector>

#include "common/slam/pose_graph.h"
#include "cpu/match_scan.h"
#include "cpu/scan_chain.h"

namespace parloc::cpu {

class PieceMatcher {
 public:
  /// All must outlive it.
  PieceMatcher(const SlamConfig& config, const std::vector<BeamTable>& scans, const ScanChain& chain,
               const std::vector<Piece>& pieces);

  struct Fit {
    Pose pose;
    float fit;
  };
  struct Found {
    std::vector<Fit> places;       ///< Of piece b seen from piece a, the best first.
    std::optional<PoseEdge> edge;  ///< The best, from a to b; nothing where it is none or one of several.
  };

  /// Looks for piece `b` up to `reach_m` around `guess` along x and y, both seen from piece `a`.
  Found match(std::size_t a, std::size_t b, const Pose& guess, double reach_m) const;
  /// Whether another place of a piece speaks against the best one: elsewhere, and about as good.
  static bool rivals(const Fit& best, const Fit& other);

 private:
  BeamTable beams_of(std::size_t piece, std::size_t most) const;
  std::vector<Fit> best_places(const TileMap& map, std::size_t b, const Pose& guess, double reach_m) const;
  Matrix3 spread(const TileMap& map, const BeamTable& beams, const Pose& at) const;

  SlamConfig config_;
  MatchScanRules climb_;
  double wide_m_;
  SearchRules wide_, narrow_;
  const std::vector<BeamTable>& scans_;
  const ScanChain& chain_;
  const std::vector<Piece>& pieces_;
};

}  // namespace parloc::cpu
