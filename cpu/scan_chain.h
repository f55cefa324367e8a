// The way from scan to scan alone, and the pieces it is cut into for closing loops.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/flow/pose_algebra.h"
#include "common/slam/close_loops.h"

namespace parloc::cpu {

/// By scan that was taken in.
struct ScanChain {
  std::vector<Pose> pose;     ///< The first is the particle's.
  std::vector<float> fit;     ///< Of the scan to those before it, as ScanMatch has it.
  std::vector<double> way_m;  ///< From the first.
};

/// Each scan matched to a local map of the last ones, from where the particle or else the odometry says. What
/// a loop that was closed wrongly, or with a step, did to the particle's way is not in it.
/// `watch`, told how much of it is done, may be empty.
ScanChain chain_scans(const SlamConfig& config, const ScannedPath& way,
                      const std::function<void(double fraction)>& watch);

/// Scans [begin, end) in a row, and the one in the middle for whose pose they stand.
struct Piece {
  std::size_t begin, end, middle;
};
std::vector<Piece> cut_in_pieces(const ScanChain& chain);

/// How sure the chain is of scan `to` seen from scan `from`, which is before it.
Matrix3 chain_covariance(const ScanChain& chain, std::size_t from, std::size_t to);

}  // namespace parloc::cpu
