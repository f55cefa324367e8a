// The stages of grid SLAM as OpenMP loops; contract in common/slam/slam_stages.h.
#pragma once

#include <memory>
#include <vector>

#include "common/slam/slam_stages.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

/// The tiles of all particles, and who uses them.
class TileStore {
 public:
  TileStore();
  TilePool pool() const { return {chunk_.data()}; }
  /// Tiles in use, the empty one included, and tiles that there is room for.
  std::size_t used() const { return used_; }
  std::size_t capacity() const { return refs_.size(); }
  std::uint32_t* refs() { return refs_.data(); }
  void set_used(std::size_t n) { used_ = n; }
  /// What tables name from now on.
  void set_refs(std::vector<std::uint32_t> refs);
  /// Room for so many more than are in use. Throws std::bad_alloc before anything has changed.
  void make_room(std::size_t more);

 private:
  std::vector<std::unique_ptr<Tile[]>> memory_;
  std::vector<Tile*> chunk_;
  std::vector<std::uint32_t> refs_;  ///< Tables that name a tile; 0: free.
  std::size_t used_ = 1;
};

/// A tile that a particle is about to write for the first time.
struct NewTile {
  std::uint32_t id, from;
  std::size_t place;  ///< In the tables of all particles.
};

void propose(const ProposeRules& rules, const Beams& beams, const SlamMaps& maps, const Particles& particles,
             float* likelihood, Workers& workers);
/// `other`: the tables of the next step, as many.
void inherit_tiles(const std::uint32_t* ancestor, std::size_t particles, const SlamMaps& maps,
                   std::uint32_t* other, TileStore& store, Workers& workers);
/// touched: [N][span.size()], 1: the scan comes there.
void mark_tiles(const DrawRules& rules, const MatchRules& match, const Beams& beams, const TileSpan& span,
                const Particles& particles, std::uint8_t* touched, Workers& workers);
/// The places that need a tile, and what is there now.
void list_new_tiles(const std::uint8_t* touched, std::size_t particles, const SlamMaps& maps,
                    TileStore& store, std::vector<NewTile>& fresh);
void assign_tiles(std::vector<NewTile>& fresh, const SlamMaps& maps, TileStore& store, Workers& workers);
void register_scan(const DrawRules& rules, const MatchRules& match, const Beams& beams, const SlamMaps& maps,
                   const Particles& particles, const std::uint8_t* touched, Workers& workers);

}  // namespace parloc::cpu
