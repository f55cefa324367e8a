#include "cuda/scan.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct FlagNeeds {
  const std::uint8_t* touched;
  const std::uint32_t *table, *refs;
  std::uint64_t* need;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride())
      need[k] = touched[k] != 0 && (table[k] == kNoTile || refs[table[k]] > 1) ? 1 : 0;
  }
};

struct FlagFree {
  const std::uint32_t* refs;
  std::uint64_t* free;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride()) free[k] = refs[k] == 0 ? 1 : 0;
  }
};

PARLOC_HD bool is_counted(const std::uint64_t* running, std::size_t k) {
  return running[k] != (k > 0 ? running[k - 1] : 0);
}

struct ListFree {
  const std::uint64_t* free;
  std::uint32_t* ids;
  std::size_t count, wanted;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride())
      if (is_counted(free, k) && free[k] <= wanted) ids[free[k] - 1] = static_cast<std::uint32_t>(k);
  }
};

struct AssignTiles {
  const std::uint64_t* need;
  const std::uint32_t* ids;
  std::uint32_t *table, *refs;
  std::uint64_t* freed;
  NewTile* fresh;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride()) {
      if (!is_counted(need, k)) continue;
      const std::size_t rank = static_cast<std::size_t>(need[k] - 1);
      const std::uint32_t id = ids[rank], from = table[k];
      fresh[rank] = {id, from};
      table[k] = id;
      refs[id] = 1;
      release(from, refs, freed);
    }
  }
};

/// Word by word: a tile is a whole number of 64-bit words.
struct CopyTiles {
  const NewTile* fresh;
  TilePool pool;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    constexpr std::size_t kWords = sizeof(Tile) / sizeof(std::uint64_t);
    for (std::size_t k = me.first(); k < count * kWords; k += me.stride()) {
      const NewTile& t = fresh[k / kWords];
      reinterpret_cast<std::uint64_t*>(&pool.at(t.id))[k % kWords] =
          reinterpret_cast<const std::uint64_t*>(&pool.at(t.from))[k % kWords];
    }
  }
};

}  // namespace

void SlamStages::find_new_tiles(const SlamArgs& args, const TileStore& store, NewTiles& places,
                                Queue& queue) {
  const std::size_t count = args.particles.capacity * args.maps.span.size();
  std::uint64_t* const need = places.need.data();
  launch(FlagNeeds{args.touched, args.maps.table, store.refs(), need, count}, blocks_for(count), queue);
  inclusive_scan(need, count, queue);
  copy_up(places.needed.data(), need + count - 1, sizeof *need, queue);
}

void SlamStages::assign_tiles(const SlamArgs& args, TileStore& store, NewTiles& places, Queue& queue) {
  const std::size_t needed = places.count(), tiles = store.capacity();
  const std::size_t count = args.particles.capacity * args.maps.span.size();
  if (needed == 0) return;
  places.free.reserve(tiles);
  places.ids.reserve(needed);
  places.fresh.reserve(needed);
  std::uint64_t* const free = places.free.data();
  std::uint32_t* const ids = places.ids.data();
  launch(FlagFree{store.refs(), free, tiles}, blocks_for(tiles), queue);
  inclusive_scan(free, tiles, queue);
  launch(ListFree{free, ids, tiles, needed}, blocks_for(tiles), queue);
  launch(AssignTiles{places.need.data(), ids, args.maps.table, store.refs(), store.freed(),
                     places.fresh.data(), count},
         blocks_for(count), queue);
  launch(CopyTiles{places.fresh.data(), store.pool(), needed}, blocks_for(needed * (sizeof(Tile) / 8)),
         queue);
  store.note_taken(needed);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
