// The stages of grid SLAM as kernels; contract in common/slam/slam_stages.h. All are asynchronous on the
// queue, allocate nothing and can be recorded.
#pragma once

#include <vector>

#include "common/math/atomics.h"
#include "common/math/block_sum.h"
#include "common/slam/engine/slam_report.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Places that count, and how many of them there are up to each (cuda/scan.h).
struct CountedPlaces {
  std::uint64_t *within = nullptr, *before = nullptr;
  PARLOC_HD bool counts(std::size_t k) const { return within[k] != (k % kSumBlock > 0 ? within[k - 1] : 0); }
  /// Of one that counts: those before it.
  PARLOC_HD std::uint64_t rank(std::size_t k) const { return before[k / kSumBlock] + within[k] - 1; }
};

/// A tile that a particle is about to write for the first time.
struct NewTile {
  std::uint32_t id, from;
};

/// Scratch for handing out tiles that nobody uses.
struct FreeTiles {
  CountedPlaces counted;         ///< [tiles]
  std::uint32_t* ids = nullptr;  ///< [tiles] Those to be taken, ascending.
  NewTile* fresh = nullptr;      ///< [tiles] What becomes of them.
};

/// The tiles of all particles, and who uses them.
class TileStore {
 public:
  explicit TileStore(Queue& queue);
  TilePool pool() const { return {chunk_.data()}; }
  std::uint32_t* refs() const { return refs_.data(); }  ///< Tables that name a tile; 0: free.
  std::uint64_t* used() const { return used_.data(); }  ///< [1] Tiles in use, the empty one included.
  FreeTiles free_list() const { return {{free_.data(), before_.data()}, ids_.data(), fresh_.data()}; }
  std::size_t capacity() const { return first_.size() * kChunkTiles; }
  /// Waits.
  std::size_t used(const Queue& queue) const { return static_cast<std::size_t>(used_.to_host(1, queue)[0]); }
  void read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue& queue) const;
  void write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue& queue);
  /// What tables name from now on, and what they name.
  void set_references(const std::vector<std::uint32_t>& refs, Queue& queue);
  /// The first `count` that no table names; there must be so many.
  std::vector<std::uint32_t> first_free(std::size_t count, const Queue& queue) const;
  /// Room for so many in all; waits. Throws before anything has changed.
  void make_room(std::size_t tiles, Queue& queue);

 private:
  Tile* tile(std::uint32_t id) const { return first_[id >> kChunkShift] + (id & (kChunkTiles - 1)); }

  std::vector<DeviceBuffer<Tile>> memory_;  ///< Each of one chunk or more.
  std::vector<Tile*> first_;                ///< Of each chunk.
  DeviceBuffer<Tile*> chunk_;               ///< The same on the device.
  DeviceBuffer<std::uint32_t> refs_;
  DeviceBuffer<std::uint64_t> used_;
  DeviceBuffer<std::uint64_t> free_, before_;
  DeviceBuffer<std::uint32_t> ids_;
  DeviceBuffer<NewTile> fresh_;
};

/// One use less; the tile is free if it was the last.
PARLOC_HD void release(std::uint32_t id, std::uint32_t* refs, std::uint64_t* used) {
  if (id != kNoTile && atomic_add(&refs[id], ~0u) == 1) atomic_add(used, ~std::uint64_t{0});
}

/// The places of tables that need a tile of their own, and what is known of the scan that needs them.
class NewTiles {
 public:
  NewTiles() { tally_.reserve(1); }
  /// For tables of so many places.
  void reserve(std::size_t places) {
    need_.reserve(places);
    before_.reserve(sum_blocks(places));
  }
  void clear(Queue& queue) { tally_.from_host({SlamTally{}}, queue); }
  CountedPlaces places() const { return {need_.data(), before_.data()}; }
  SlamTally* tally() const { return tally_.data(); }
  /// Waits.
  SlamTally counted(const Queue& queue) const { return tally_.to_host(1, queue)[0]; }

 private:
  DeviceBuffer<std::uint64_t> need_, before_;
  DeviceBuffer<SlamTally> tally_;
};

/// Before scans are marked: a thread per place of the tables.
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
