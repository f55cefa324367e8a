// The stages of grid SLAM as kernels; contract in common/slam/slam_stages.h. All are asynchronous on the
// queue.
#pragma once

#include <memory>
#include <vector>

#include "common/math/atomics.h"
#include "common/slam/slam_stages.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// The tiles of all particles, and who uses them.
class TileStore {
 public:
  explicit TileStore(Queue& queue);
  TilePool pool() const { return {chunk_.data()}; }
  std::uint32_t* refs() const { return refs_.data(); }    ///< Tables that name a tile; 0: free.
  std::uint64_t* freed() const { return freed_.data(); }  ///< Counts the tiles that were given back.
  std::size_t capacity() const { return memory_.size() * kChunkTiles; }
  /// Tiles in use, the empty one included; waits.
  std::size_t used(const Queue& queue) const { return taken_ - freed_.to_host(1, queue)[0]; }
  void note_taken(std::size_t tiles) { taken_ += tiles; }
  void read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue& queue) const;
  void write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue& queue);
  /// What tables name from now on, and what they name.
  void set_references(const std::vector<std::uint32_t>& refs, Queue& queue);
  std::vector<std::uint32_t> references(const Queue& queue) const { return refs_.to_host(capacity(), queue); }
  /// Room for so many in all. Throws before anything has changed.
  void make_room(std::size_t tiles, Queue& queue);

 private:
  std::vector<std::unique_ptr<DeviceBuffer<Tile>>> memory_;
  DeviceBuffer<Tile*> chunk_;
  DeviceBuffer<std::uint32_t> refs_;
  DeviceBuffer<std::uint64_t> freed_;
  std::size_t taken_ = 1;  ///< That were ever taken into use.
};

/// One use less; counts the tile if it was the last.
PARLOC_HD void release(std::uint32_t id, std::uint32_t* refs, std::uint64_t* freed) {
  if (id != kNoTile && atomic_add(&refs[id], 0xffffffffu) == 1) atomic_add(freed, std::uint64_t{1});
}

/// A tile that a particle is about to write for the first time.
struct NewTile {
  std::uint32_t id, from;
};

struct NewTiles {
  NewTiles() { needed.reserve(1); }
  /// For tables of so many places.
  void reserve(std::size_t places) { need.reserve(places); }
  std::size_t count() const { return static_cast<std::size_t>(*needed.data()); }

  DeviceBuffer<std::uint64_t> need;  ///< [N][span]: running count of the places that need a tile.
  HostBuffer<std::uint64_t> needed;  ///< [1] The last of them.
  DeviceBuffer<std::uint64_t> free;  ///< [tiles]: running count of the free ones.
  DeviceBuffer<std::uint32_t> ids;   ///< Free tiles, ascending.
  DeviceBuffer<NewTile> fresh;
};

/// Before a scan is marked: a thread per place of the tables.
struct ClearMarks {
  std::uint8_t* touched;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride()) touched[k] = 0;
  }
};

struct SlamStages {
#include "common/slam/stage_list.inc"
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
