// The path from scan to scan alone, and the pieces it is cut into for closing loops.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/flow/pose_algebra.h"
#include "common/slam/loops/close_loops.h"

namespace parloc {

/// By scan that was taken in.
struct ScanChain {
  std::vector<Pose> pose;           ///< Map frame; the first is the particle's.
  std::vector<float> fit;           ///< Of the scan to those before it, as ScanMatch has it.
  std::vector<double> travelled_m;  ///< Along the chain, from the first.
};

/// Each scan matched to a local map of the last ones, from where the particle or else the odometry says. What
/// a loop that was closed wrongly, or with a step, did to the particle's path is not in it.
/// `watch`, told how much of it is done, may be empty.
ScanChain chain_scans(const ScannedPath& scanned, ScanMatcher& matcher,
                      const std::function<void(double fraction)>& watch);

/// Scans [begin, end) in a row, and the one in the middle for whose pose they stand.
struct Piece {
  std::size_t begin, end, middle;
};
std::vector<Piece> cut_in_pieces(const ScanChain& chain);
/// Scans [begin, end) of a piece and of those beside it.
Piece with_neighbours(const std::vector<Piece>& pieces, std::size_t piece);

/// How sure the chain is of scan `to` seen from scan `from`, which is before it.
Matrix3 chain_covariance(const ScanChain& chain, std::size_t from, std::size_t to);

}  // namespace parloc
