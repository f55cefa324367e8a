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

void count_new_tiles(const std::uint8_t* touched, std::size_t particles, const SlamMaps& maps,
                     const std::uint32_t* refs, AssignRoom& room, Scratch& scratch, Stream stream) {
  const std::size_t count = particles * maps.span.size();
  launch(FlagNeeds{touched, maps.table, refs, room.need.data(), count}, blocks_for(count), stream);
  inclusive_scan(room.need.data(), room.need.data(), count, scratch, stream);
}

void assign_tiles(std::size_t needed, std::size_t particles, const SlamMaps& maps, TileStore& store,
                  std::uint64_t* freed, AssignRoom& room, Scratch& scratch, Stream stream) {
  if (needed == 0) return;
  const std::size_t tiles = store.capacity(), count = particles * maps.span.size();
  room.free.reserve(tiles);
  room.ids.reserve(needed);
  room.fresh.reserve(needed);
  scratch.reserve(tiles);
  launch(FlagFree{store.refs(), room.free.data(), tiles}, blocks_for(tiles), stream);
  inclusive_scan(room.free.data(), room.free.data(), tiles, scratch, stream);
  launch(ListFree{room.free.data(), room.ids.data(), tiles, needed}, blocks_for(tiles), stream);
  launch(AssignTiles{room.need.data(), room.ids.data(), maps.table, store.refs(), freed, room.fresh.data(),
                     count},
         blocks_for(count), stream);
  launch(CopyTiles{room.fresh.data(), store.pool(), needed}, blocks_for(needed * (sizeof(Tile) / 8)), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
