// The maps of a scan matcher in host memory; contract in common/slam/matching/matching_stages.h.
#pragma once

#include <vector>

#include "common/slam/matching/scan_matcher.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

class DraftMaps {
 public:
  DraftMaps(const MatcherRules& rules, int threads) : rules_(rules), threads_(threads) {}
  void clear();
  void draw(const std::vector<ScanDrawing>& drawings);
  TileMap view(std::size_t map) const;
  SlamCells cells(std::size_t map) const;

 private:
  void cover(const std::vector<ScanDrawing>& drawings);
  SlamMaps maps() { return {span_, table_.data(), store_.pool()}; }

  MatcherRules rules_;
  int threads_;
  std::size_t count_ = 0;  ///< Of the maps.
  TileSpan span_;
  std::vector<std::uint32_t> table_;   ///< [maps][span.size()]
  std::vector<std::uint8_t> touched_;  ///< Likewise.
  TileStore store_;
  std::vector<NewTile> fresh_;
};

}  // namespace parloc::cpu
