// One map in host memory that is drawn scan by scan, in the cells of grid SLAM.
#pragma once

#include <memory>
#include <vector>

#include "common/slam/slam_stages.h"

namespace parloc::cpu {

class DraftMap {
 public:
  DraftMap(const DrawRules& draw, const MatchRules& match);
  /// Forgets all scans; the memory is kept.
  void clear();
  /// As register_scan does for one particle.
  void draw(const Beams& beams, const SlamPose& pose);
  bool empty() const { return used_ == 1; }
  TileMap view() const { return {span_, table_.data(), {chunk_.data()}}; }

 private:
  void cover(const SlamPose& pose);
  std::uint32_t new_tile();

  DrawRules draw_;
  MatchRules match_;
  TileSpan span_;
  std::vector<std::uint32_t> table_;
  std::vector<std::uint8_t> touched_;
  std::vector<std::unique_ptr<Tile[]>> memory_;
  std::vector<Tile*> chunk_;
  std::uint32_t used_ = 1;  ///< Tiles, the empty one included.
};

}  // namespace parloc::cpu
