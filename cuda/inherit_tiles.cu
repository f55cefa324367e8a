#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Likelihoods always, tables where the particles were resampled.
struct CopyTables {
  SlamArgs args;
  std::uint32_t* refs;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t particles = args.particles.count(), size = args.maps.span.size();
    const std::uint32_t* const ancestor = args.ancestor;
    for (std::size_t j = me.first(); j < particles; j += me.stride())
      args.other_likelihood[j] = args.likelihood[ancestor[j]];
    if (!has_resampled(args)) return;
    for (std::size_t k = me.first(); k < particles * size; k += me.stride()) {
      const std::uint32_t id = args.maps.table[ancestor[k / size] * size + k % size];
      args.other_table[k] = id;
      if (id != kNoTile) atomic_add(&refs[id], 1u);
    }
  }
};

struct ReleaseTables {
  SlamArgs args;
  std::uint32_t* refs;
  std::uint64_t* used;
  PARLOC_HD void operator()(const Thread& me) const {
    if (!has_resampled(args)) return;
    const std::size_t count = args.particles.count() * args.maps.span.size();
    for (std::size_t k = me.first(); k < count; k += me.stride()) release(args.maps.table[k], refs, used);
  }
};

}  // namespace

void SlamStages::inherit_tiles(const SlamArgs& args, TileStore& store, Queue& queue) {
  const unsigned blocks = blocks_for(args.particles.capacity * args.maps.span.size());
  launch(CopyTables{args, store.refs()}, blocks, queue);
  launch(ReleaseTables{args, store.refs(), store.used()}, blocks, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
