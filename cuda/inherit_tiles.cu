#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct CopyTables {
  const std::uint32_t *ancestor, *from;
  std::uint32_t *to, *refs;
  std::size_t particles, size;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < particles * size; k += me.stride()) {
      const std::uint32_t id = from[ancestor[k / size] * size + k % size];
      to[k] = id;
      if (id != kNoTile) atomic_add(&refs[id], 1u);
    }
  }
};

struct ReleaseTables {
  const std::uint32_t* table;
  std::uint32_t* refs;
  std::uint64_t* freed;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < count; k += me.stride()) release(table[k], refs, freed);
  }
};

}  // namespace

void SlamStages::inherit_tiles(const SlamArgs& args, const std::uint32_t* ancestor, std::uint32_t* other,
                               TileStore& store, Queue& queue) {
  const std::uint32_t* const table = args.maps.table;
  const std::size_t particles = args.particles.capacity, size = args.maps.span.size();
  const std::size_t count = particles * size;
  launch(CopyTables{ancestor, table, other, store.refs(), particles, size}, blocks_for(count), queue);
  launch(ReleaseTables{table, store.refs(), store.freed(), count}, blocks_for(count), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
