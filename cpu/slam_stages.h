// The stages of grid SLAM as OpenMP loops; contract in common/slam/slam_stages.h.
#pragma once

#include <memory>
#include <vector>

#include "common/slam/engine/slam_report.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

/// The tiles of all particles, and who uses them.
class TileStore {
 public:
  explicit TileStore(Queue& queue);
  TilePool pool() const { return {chunk_.data()}; }
  std::uint32_t* refs() { return refs_.data(); }  ///< Tables that name a tile; 0: free.
  /// Tiles that there is room for, and tiles in use, the empty one included.
  std::size_t capacity() const { return refs_.size(); }
  std::size_t used(const Queue&) const { return used_; }
  void change_used(std::size_t taken, std::size_t freed) { used_ += taken - freed; }
  void read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue& queue) const;
  void write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue& queue);
  /// What tables name from now on, and what they name.
  void set_references(std::vector<std::uint32_t> refs, Queue& queue);
  /// The first `count` that no table names; there must be so many.
  std::vector<std::uint32_t> first_free(std::size_t count, const Queue& queue) const;
  /// Room for so many in all. Throws std::bad_alloc before anything has changed.
  void make_room(std::size_t tiles, Queue& queue);

 private:
  std::vector<std::unique_ptr<Tile[]>> memory_;
  std::vector<Tile*> chunk_;
  std::vector<std::uint32_t> refs_;
  std::size_t used_ = 1;
};

/// A tile that a particle is about to write for the first time.
struct NewTile {
  std::uint32_t id, from;
  std::size_t place;  ///< In the tables of all particles.
};
struct NewTiles {
  void reserve(std::size_t) {}
  void clear(Queue&) { counted = {}; }
  SlamTally* tally() { return &counted; }
  std::vector<NewTile> tiles;
  SlamTally counted;
};

struct SlamStages {
#include "common/slam/stage_list.inc"
};

}  // namespace parloc::cpu
