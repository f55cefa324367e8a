#include "common/filter/weights/moments.h"

#include "common/filter/bins.h"
#include "cpu/block_sum.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// Puts particles into bins for one thread. Most fall into few bins: their weights are added up here first,
/// so that a particle seldom costs a search and threads seldom meet at the table.
class BinFiller {
 public:
  explicit BinFiller(const BinTable& table) : table_(table) {}
  ~BinFiller() {
    for (Bin& bin : recent_) settle(bin);
  }
  std::uint32_t add(std::uint64_t key, std::uint64_t weight) {
    Bin& bin = recent_[bin_hash(key, kRecent)];
    if (bin.key != key) {
      settle(bin);
      bin = {key, 0, bin_find_or_make(table_, key)};
    }
    bin.weight += weight;
    return bin.slot;
  }

 private:
  struct Bin {
    std::uint64_t key = kNoBin, weight = 0;
    std::uint32_t slot = 0;
  };
  static constexpr std::uint32_t kRecent = 64;
  void settle(const Bin& bin) {
    if (bin.key != kNoBin) atomic_add(&table_.weight[bin.slot], bin.weight);
  }
  BinTable table_;
  Bin recent_[kRecent];
};

void fill_bins(const Particles& p, const std::uint64_t* weight, const BinTable& bins, Workers& workers) {
  parallel_for(p.count(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    constexpr std::size_t kChunk = 512;
    std::uint64_t key[kChunk];
    BinFiller filler(bins);
    for (std::size_t first = begin; first < end; first += kChunk) {
      const std::size_t here = end - first < kChunk ? end - first : kChunk;
      for (std::size_t k = 0; k < here; ++k)
        key[k] = bin_key_of(p.x[first + k], p.y[first + k], p.theta[first + k]);
      for (std::size_t k = 0; k < here; ++k) bins.slot_of[first + k] = filler.add(key[k], weight[first + k]);
    }
  });
}

/// Slot of the root of the heaviest cluster; equal weights: the smaller key. Afterwards every used slot's
/// parent is its root, so that membership is one look-up.
std::uint32_t heaviest_cluster(const BinTable& t) {
  const std::size_t used = *t.used_count;
  for (std::size_t k = 0; k < used; ++k)
    for (std::uint32_t n = 0; n < kBinNeighbours; ++n) bin_join_neighbour(t, t.used[k], n);
  for (std::size_t k = 0; k < used; ++k) {
    const std::uint32_t slot = t.used[k], root = bin_root(t, slot);
    t.parent[slot] = root;
    if (root != slot) t.weight[root] += t.weight[slot];
  }
  std::uint32_t best = t.parent[t.used[0]];
  for (std::size_t k = 0; k < used; ++k) {
    const std::uint32_t root = t.parent[t.used[k]];
    const bool heavier = t.weight[root] > t.weight[best];
    const bool equal = t.weight[root] == t.weight[best];
    if (heavier || (equal && t.key[root] < t.key[best])) best = root;
  }
  return best;
}

}  // namespace

void FilterStages::clear_bins(const BinTable& bins, Queue&) {
  for (std::uint32_t slot = 0; slot < bins.capacity; ++slot) bin_clear(bins, slot);
  *bins.used_count = 0;
}

void FilterStages::estimate(const EstimateArgs& args, Queue& workers) {
  const Particles p = args.particles;
  const BinTable bins = args.bins;
  StepState* const state = args.state;
  const std::uint64_t* weight = args.weights.weight;
  const std::size_t count = p.count();
  fill_bins(p, weight, bins, workers);
  const std::uint32_t best = heaviest_cluster(bins);
  state->best_slot = best;

  const double total = static_cast<double>(state->total);
  const double cluster_weight = static_cast<double>(bins.weight[best]);
  const auto in_cluster = [=](std::size_t i)
                              PARLOC_SIMD_LOOP { return bins.parent[bins.slot_of[i]] == best; };

  const SumVector<kMeanSums> mean = block_sum<kMeanSums>(count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP {
    return mean_terms(p.x[i], p.y[i], p.theta[i], weight[i], in_cluster(i));
  });
  finish_mean(state->all, mean.v, total, total);
  finish_mean(state->cluster, mean.v + 4, cluster_weight, total);

  const Moments all = state->all, cluster = state->cluster;
  const SumVector<kCovarianceSums> cov =
      block_sum<kCovarianceSums>(count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP {
        return covariance_terms(p.x[i], p.y[i], p.theta[i], weight[i], in_cluster(i), all, cluster);
      });
  finish_covariance(state->all, cov.v, total);
  finish_covariance(state->cluster, cov.v + 6, cluster_weight);
  bin_clear_used(bins);
}

}  // namespace parloc::cpu
