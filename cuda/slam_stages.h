// The stages of grid SLAM as kernels; contract in common/slam/slam_stages.h. All are asynchronous on
// `stream`.
#pragma once

#include <memory>
#include <vector>

#include "common/math/atomics.h"
#include "common/slam/slam_stages.h"
#include "cuda/launch.h"
#include "cuda/memory.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// The tiles of all particles, and who uses them.
class TileStore {
 public:
  explicit TileStore(Stream stream);
  TilePool pool() const { return {chunk_.data()}; }
  std::uint32_t* refs() const { return refs_.data(); }  ///< Tables that name a tile; 0: free.
  std::size_t capacity() const { return memory_.size() * kChunkTiles; }
  void read(const std::vector<std::uint32_t>& ids, Tile* to, Stream stream) const;
  void write(const std::vector<std::uint32_t>& ids, const Tile* from, Stream stream);
  /// Room for so many tiles. Throws before anything has changed.
  void make_room(std::size_t tiles, Stream stream);

 private:
  std::vector<std::unique_ptr<DeviceBuffer<Tile>>> memory_;
  DeviceBuffer<Tile*> chunk_;
  DeviceBuffer<std::uint32_t> refs_;
};

/// One use less; counts the tile if it was the last.
PARLOC_HD void release(std::uint32_t id, std::uint32_t* refs, std::uint64_t* freed) {
  if (id != kNoTile && atomic_add(&refs[id], 0xffffffffu) == 1) atomic_add(freed, std::uint64_t{1});
}

/// A tile that a particle is about to write for the first time.
struct NewTile {
  std::uint32_t id, from;
};

/// Scratch of assign_tiles.
struct AssignRoom {
  DeviceBuffer<std::uint64_t> need;  ///< [N][span]: running count of the places that need a tile.
  DeviceBuffer<std::uint64_t> free;  ///< [tiles]: running count of the free ones.
  DeviceBuffer<std::uint32_t> ids;   ///< Free tiles, ascending.
  DeviceBuffer<NewTile> fresh;
};

void propose(const ProposeRules& rules, const Beams& beams, const SlamMaps& maps, const Particles& particles,
             float* likelihood, Stream stream);
/// `other`: the tables of the next step, as many; `freed`: counts tiles that nobody uses any more.
void inherit_tiles(const std::uint32_t* ancestor, std::size_t particles, const SlamMaps& maps,
                   std::uint32_t* other, std::uint32_t* refs, std::uint64_t* freed, Stream stream);
/// touched: [N][span.size()], 1: the scan comes there.
void mark_tiles(const DrawRules& rules, const MatchRules& match, const Beams& beams, const TileSpan& span,
                const Particles& particles, std::uint8_t* touched, Stream stream);
/// How many tiles assign_tiles will take: in the last element of room.need.
void count_new_tiles(const std::uint8_t* touched, std::size_t particles, const SlamMaps& maps,
                     const std::uint32_t* refs, AssignRoom& room, Scratch& scratch, Stream stream);
void assign_tiles(std::size_t needed, std::size_t particles, const SlamMaps& maps, TileStore& store,
                  std::uint64_t* freed, AssignRoom& room, Scratch& scratch, Stream stream);
void register_scan(const DrawRules& rules, const MatchRules& match, const Beams& beams, const SlamMaps& maps,
                   const Particles& particles, const std::uint8_t* touched, Stream stream);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
