// The maps of a scan matcher in host memory; contract in common/slam/matching/matching_stages.h.
#pragma once

#include <memory>
#include <vector>

#include "common/slam/matching/scan_matcher.h"

namespace parloc::cpu {

/// One of them.
class DraftMap {
 public:
  explicit DraftMap(const MatcherRules& rules);
  void clear();
  /// Makes the table large enough for these scans; they must be drawn only then.
  void cover(const std::vector<ScanDrawing>& drawings);
  void draw(const ScanDrawing& drawing);
  TileMap view() const { return {span_, table_.data(), {chunk_.data()}}; }

 private:
  std::uint32_t new_tile();

  MatcherRules rules_;
  TileSpan span_;
  std::vector<std::uint32_t> table_;
  std::vector<std::uint8_t> touched_;
  std::vector<std::unique_ptr<Tile[]>> memory_;
  std::vector<Tile*> chunk_;
  std::uint32_t used_ = 0;  ///< Tiles, the empty one included.
};

class DraftMaps {
 public:
  DraftMaps(const MatcherRules& rules, int threads) : rules_(rules), threads_(threads) {}
  void clear();
  void draw(const std::vector<ScanDrawing>& drawings);
  TileMap view(std::size_t map);

 private:
  void make(std::size_t maps);

  MatcherRules rules_;
  int threads_;
  std::vector<DraftMap> map_;
};

}  // namespace parloc::cpu
