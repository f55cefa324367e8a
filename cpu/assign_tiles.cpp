#include <cstring>

#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::find_new_tiles(const SlamArgs& args, TileStore& store, NewTiles& places, Queue& workers) {
  const std::uint32_t* const table = inherited_maps(args).table;
  const std::size_t count = args.particles.count() * args.maps.span.size();
  std::vector<NewTile>& fresh = places.tiles;
  fresh.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (args.touched[k] == 0) continue;
    const std::uint32_t id = table[k];
    if (id == kNoTile || store.refs()[id] != 1) fresh.push_back({0, id, k});
  }
  decide(*args.tally, store.used(workers), fresh.size(), store.capacity(), args.input->most_tiles);
}

void SlamStages::assign_tiles(const SlamArgs& args, TileStore& store, NewTiles& places, Queue& workers) {
  if (args.tally->fits == 0) return;
  std::uint32_t* const table = inherited_maps(args).table;
  std::vector<NewTile>& fresh = places.tiles;
  std::uint32_t* refs = store.refs();
  std::uint32_t next = 1;
  std::size_t freed = 0;
  for (NewTile& tile : fresh) {
    while (refs[next] != 0) ++next;
    tile.id = next++;
  }
  for (const NewTile& tile : fresh) {
    refs[tile.id] = 1;
    table[tile.place] = tile.id;
  }
  for (const NewTile& tile : fresh)
    if (tile.from != kNoTile) freed += --refs[tile.from] == 0 ? 1 : 0;
  store.change_used(fresh.size(), freed);
  const TilePool pool = store.pool();
  parallel_blocks(fresh.size(), workers.threads, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      std::memcpy(&pool.at(fresh[k].id), &pool.at(fresh[k].from), sizeof(Tile));
  });
}

}  // namespace parloc::cpu
