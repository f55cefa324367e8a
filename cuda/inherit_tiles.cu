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

void inherit_tiles(const std::uint32_t* ancestor, std::size_t particles, const SlamMaps& maps,
                   std::uint32_t* other, std::uint32_t* refs, std::uint64_t* freed, Stream stream) {
  const std::size_t size = maps.span.size(), count = particles * size;
  launch(CopyTables{ancestor, maps.table, other, refs, particles, size}, blocks_for(count), stream);
  launch(ReleaseTables{maps.table, refs, freed, count}, blocks_for(count), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
