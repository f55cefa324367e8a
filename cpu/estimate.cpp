#include "common/filter/estimate.h"

#include "common/filter/bins.h"
#include "cpu/block_sum.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

/// Slot of the root of the heaviest cluster; equal weights: the smaller key. Afterwards every used slot's
/// parent is its root, so that membership is one look-up.
std::uint32_t heaviest_cluster(const BinTable& t) {
  const std::size_t used = *t.used_count;
  for (std::size_t k = 0; k < used; ++k) bin_join_neighbours(t, t.used[k]);
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

void clear_bins(const BinTable& t) {
  for (std::size_t k = 0; k < *t.used_count; ++k) bin_clear(t, t.used[k]);
  *t.used_count = 0;
}

}  // namespace

void estimate(const Particles& p, const Weights& weights, const BinTable& bins, StepState* state,
              Workers& workers) {
  const std::uint64_t* weight = weights.weight;
  parallel_for(p.count, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i)
      bins.slot_of[i] = bin_insert(bins, bin_key_of(p.x[i], p.y[i], p.theta[i]), weight[i]);
  });
  const std::uint32_t best = heaviest_cluster(bins);
  state->best_slot = best;

  const double total = static_cast<double>(state->total);
  const double cluster_weight = static_cast<double>(bins.weight[best]);
  const auto in_cluster = [=](std::size_t i)
                              PARLOC_SIMD_LOOP { return bins.parent[bins.slot_of[i]] == best; };

  const SumVector<kMeanSums> mean =
      block_sum<kMeanSums>(p.count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP {
        return mean_terms(p.x[i], p.y[i], p.theta[i], weight[i], in_cluster(i));
      });
  finish_mean(state->all, mean.v, total, total);
  finish_mean(state->cluster, mean.v + 4, cluster_weight, total);

  const Moments all = state->all, cluster = state->cluster;
  const SumVector<kCovarianceSums> cov =
      block_sum<kCovarianceSums>(p.count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP {
        return covariance_terms(p.x[i], p.y[i], p.theta[i], weight[i], in_cluster(i), all, cluster);
      });
  finish_covariance(state->all, cov.v, total);
  finish_covariance(state->cluster, cov.v + 6, cluster_weight);
  clear_bins(bins);
}

}  // namespace parloc::cpu
