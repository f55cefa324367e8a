// The maps of a scan matcher in device memory; contract in common/slam/matching/matching_stages.h.
#pragma once

#include <vector>

#include "common/slam/matching/scan_matcher.h"
#include "cuda/scans.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// A scan where the kernels find it.
struct PlacedScan {
  std::size_t map = 0;
  Beams scan;
  MatchPose pose;
};

class DraftMaps {
 public:
  /// `queue` outlives this.
  DraftMaps(const MatcherRules& rules, Queue& queue);
  void clear();
  void draw(const std::vector<ScanDrawing>& drawings);
  TileMap view(std::size_t map) const;
  SlamCells cells(std::size_t map) const;

 private:
  void cover(const std::vector<ScanDrawing>& drawings);
  void make_tiles(std::size_t scans, std::size_t most_drawn);
  SlamMaps maps() const { return {span_, table_.data(), store_.pool()}; }

  MatcherRules rules_;
  Queue& queue_;
  std::size_t count_ = 0;  ///< Of the maps.
  TileSpan span_;
  DeviceBuffer<std::uint32_t> table_;   ///< [maps][span.size()]
  DeviceBuffer<std::uint8_t> touched_;  ///< Likewise.
  TileStore store_;
  DeviceScans scans_;
  DeviceBuffer<PlacedScan> placed_;
  NewTiles new_tiles_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
