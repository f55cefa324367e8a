#include <algorithm>

#include "cuda/scan.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// 1 for a place that the scan comes to, and whose tile the particle has not to itself.
struct NeedsTile {
  SlamArgs args;
  const std::uint32_t* refs;
  PARLOC_HD std::uint64_t operator()(std::size_t k) const {
    if (args.touched[k] == 0) return 0;
    const std::uint32_t id = inherited_maps(args).table[k];
    return id == kNoTile || refs[id] > 1 ? 1 : 0;
  }
};

struct IsFree {
  const std::uint32_t* refs;
  PARLOC_HD std::uint64_t operator()(std::size_t k) const { return refs[k] == 0 ? 1 : 0; }
};

/// Counts the places that need a tile, and then decides whether the scan is written.
struct FindNewTiles {
  using Shared = ScanBlocks<NeedsTile>::Shared;
  ScanBlocks<NeedsTile> scan;
  std::uint32_t* arrived;
  const std::uint64_t* used;
  std::uint64_t capacity;

  PARLOC_HD int join_phase() const { return scan.join_phase(); }
  PARLOC_HD int phases() const { return scan.phases() + 1; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (phase < scan.phases()) return scan(me, phase, s);
    if (me.thread > 0) return;
    const SlamArgs& args = scan.value.args;
    decide(*args.tally, *used, scan.totals.total(s.scan.room), capacity,
           args.input != nullptr ? args.input->most_tiles : ~std::uint64_t{0});
  }
};

/// The free tiles that will be taken, in their order.
struct ListFree {
  const SlamTally* tally;
  CountedPlaces free;
  std::uint32_t* ids;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint64_t wanted = tally->needed;
    if (tally->fits == 0) return;
    for (std::size_t k = me.first(); k < count; k += me.stride())
      if (free.counts(k) && free.rank(k) < wanted) ids[free.rank(k)] = static_cast<std::uint32_t>(k);
  }
};

struct AssignTiles {
  SlamArgs args;
  CountedPlaces need;
  const std::uint32_t* ids;
  std::uint32_t* refs;
  std::uint64_t* used;
  NewTile* fresh;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    if (args.tally->fits == 0) return;
    if (me.first() == 0) atomic_add(used, args.tally->needed);
    std::uint32_t* const table = inherited_maps(args).table;
    for (std::size_t k = me.first(); k < count; k += me.stride()) {
      if (!need.counts(k)) continue;
      const std::size_t rank = static_cast<std::size_t>(need.rank(k));
      const std::uint32_t id = ids[rank], from = table[k];
      fresh[rank] = {id, from};
      table[k] = id;
      refs[id] = 1;
      release(from, refs, used);
    }
  }
};

/// Word by word: a tile is a whole number of 64-bit words.
struct CopyTiles {
  const SlamTally* tally;
  const NewTile* fresh;
  TilePool pool;
  PARLOC_HD void operator()(const Thread& me) const {
    constexpr std::uint32_t kWords = sizeof(Tile) / sizeof(std::uint64_t);
    if (tally->fits == 0) return;
    const std::uint64_t words = tally->needed * kWords;
    for (std::size_t k = me.first(); k < words; k += me.stride()) {
      const NewTile& t = fresh[k / kWords];
      reinterpret_cast<std::uint64_t*>(&pool.at(t.id))[k % kWords] =
          reinterpret_cast<const std::uint64_t*>(&pool.at(t.from))[k % kWords];
    }
  }
};

/// Enough to keep a device busy; how many tiles are copied is not known when this is started.
constexpr unsigned kMostCopyBlocks = 1024;

}  // namespace

void SlamStages::find_new_tiles(const SlamArgs& args, TileStore& store, NewTiles& places, Queue& queue) {
  const std::size_t count = args.particles.capacity * args.maps.span.size(), blocks = sum_blocks(count);
  std::uint32_t* const arrived = queue.scratch.arrived.data();
  const CountedPlaces& need = places.places();
  launch(FindNewTiles{{{args, store.refs()}, need.within, {need.before, blocks}, count, arrived},
                      arrived,
                      store.used(),
                      store.capacity()},
         static_cast<unsigned>(blocks), queue);
}

void SlamStages::assign_tiles(const SlamArgs& args, TileStore& store, NewTiles& places, Queue& queue) {
  const std::size_t tiles = store.capacity(), count = args.particles.capacity * args.maps.span.size();
  const FreeTiles list = store.free_list();
  scan_in_blocks(IsFree{store.refs()}, tiles, list.counted.within, list.counted.before, queue);
  launch(ListFree{args.tally, list.counted, list.ids, tiles}, blocks_for(tiles), queue);
  launch(AssignTiles{args, places.places(), list.ids, store.refs(), store.used(), list.fresh, count},
         blocks_for(count), queue);
  launch(CopyTiles{args.tally, list.fresh, store.pool()}, std::min(kMostCopyBlocks, blocks_for(count)),
         queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
