#include "common/filter/estimate.h"

#include "common/filter/bins.h"
#include "cpu/block_sum.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

void clear_bins(const BinTable& t, Workers& workers) {
  parallel_for(t.capacity, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t s = begin; s < end; ++s) {
      t.key[s] = kNoBin;
      t.weight[s] = 0;
      t.cluster_weight[s] = 0;
      t.parent[s] = static_cast<std::uint32_t>(s);
    }
  });
}

/// Slot of the root of the heaviest cluster; equal weights: the smaller key.
std::uint32_t heaviest_cluster(const BinTable& t) {
  for (std::uint32_t s = 0; s < t.capacity; ++s) bin_join_neighbours(t, s);
  for (std::uint32_t s = 0; s < t.capacity; ++s)
    if (t.key[s] != kNoBin) t.cluster_weight[bin_root(t, s)] += t.weight[s];
  std::uint32_t best = t.capacity;
  for (std::uint32_t s = 0; s < t.capacity; ++s) {
    if (t.key[s] == kNoBin || t.parent[s] != s) continue;
    const bool better = best == t.capacity || t.cluster_weight[s] > t.cluster_weight[best] ||
                        (t.cluster_weight[s] == t.cluster_weight[best] && t.key[s] < t.key[best]);
    if (better) best = s;
  }
  return best;
}

}  // namespace

void estimate(const Particles& p, const Weights& weights, const BinTable& bins, StepState* state,
              Workers& workers) {
  const std::uint64_t* weight = weights.weight;
  clear_bins(bins, workers);
  parallel_for(p.count, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t i = begin; i < end; ++i)
      bins.slot_of[i] = bin_insert(bins, bin_key_of(p.x[i], p.y[i], p.theta[i]), weight[i]);
  });
  const std::uint32_t best = heaviest_cluster(bins);
  state->best_slot = best;
  for (std::uint32_t s = 0; s < bins.capacity; ++s)  // flatten, so that membership is one look-up
    if (bins.key[s] != kNoBin) bins.parent[s] = bin_root(bins, s);

  const double total = static_cast<double>(state->total);
  const double cluster_weight = static_cast<double>(bins.cluster_weight[best]);
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
}

}  // namespace parloc::cpu
