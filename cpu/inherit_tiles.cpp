#include <cstring>

#include "cpu/slam_stages.h"

namespace parloc::cpu {

void inherit_tiles(const std::uint32_t* ancestor, std::size_t particles, const SlamMaps& maps,
                   std::uint32_t* other, TileStore& store, Workers& workers) {
  const std::size_t size = maps.span.size();
  parallel_blocks(particles, workers.threads, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j)
      std::memcpy(other + j * size, maps.table + ancestor[j] * size, size * sizeof(std::uint32_t));
  });
  std::uint32_t* refs = store.refs();
  std::size_t freed = 0;
  for (std::size_t k = 0; k < particles * size; ++k)
    if (other[k] != kNoTile) ++refs[other[k]];
  for (std::size_t k = 0; k < particles * size; ++k)
    if (maps.table[k] != kNoTile && --refs[maps.table[k]] == 0) ++freed;
  store.set_used(store.used() - freed);
}

}  // namespace parloc::cpu
