#include <cstring>

#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::inherit_tiles(const SlamArgs& args, TileStore& store, Queue& workers) {
  const SlamMaps& maps = args.maps;
  const std::uint32_t* const ancestor = args.ancestor;
  const std::size_t particles = args.particles.count(), size = maps.span.size();
  for (std::size_t j = 0; j < particles; ++j) args.other_likelihood[j] = args.likelihood[ancestor[j]];
  if (!has_resampled(args)) return;
  std::uint32_t* const other = args.other_table;
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
  store.change_used(0, freed);
}

}  // namespace parloc::cpu
