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

  /// Where piece `b` lies seen from piece `a` (their numbers are the edge's ends), looked for up to `reach_m`
  /// around `guess` along x and y. Nothing where it does not fit, or fits as well somewhere else.
  std::optional<PoseEdge> match(std::size_t a, std::size_t b, const Pose& guess, double reach_m) const;

 private:
  struct Fit {
    Pose pose;
    float fit;
  };
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
