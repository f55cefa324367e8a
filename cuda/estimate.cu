#include "common/filter/moments.h"

#include "cuda/block_sum.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct FillBins {
  BinTable t;
  Particles p;
  const std::uint64_t* weight;
  std::uint64_t* best;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) best[0] = best[1] = 0;
    for (std::size_t i = me.first(); i < p.count(); i += me.stride()) {
      const std::uint32_t slot = bin_find_or_make(t, bin_key_of(p.x[i], p.y[i], p.theta[i]));
      atomic_add(&t.weight[slot], weight[i]);
      t.slot_of[i] = slot;
    }
  }
};

struct JoinBins {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) bin_join_neighbours(t, t.used[k]);
  }
};

struct SumClusters {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) {
      const std::uint32_t slot = t.used[k], root = bin_root(t, slot);
      if (root != slot) atomic_add(&t.weight[root], t.weight[slot]);
    }
  }
};

/// Heaviest weight, then among its equals the smallest key (as the largest complement).
struct FindHeaviest {
  BinTable t;
  std::uint64_t* best;
  bool by_key;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) {
      const std::uint32_t s = t.used[k];
      if (t.parent[s] != s) continue;
      if (!by_key) atomic_raise(&best[0], t.weight[s]);
      if (by_key && t.weight[s] == best[0]) atomic_raise(&best[1], ~t.key[s]);
    }
  }
};

struct ClearBins {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) bin_clear(t, t.used[k]);
  }
};

struct ClearList {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *t.used_count = 0;
  }
};

struct ClearAllBins {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *t.used_count = 0;
    for (std::size_t s = me.first(); s < t.capacity; s += me.stride())
      bin_clear(t, static_cast<std::uint32_t>(s));
  }
};

struct TakeHeaviest {
  BinTable t;
  const std::uint64_t* best;
  StepState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) state->best_slot = bin_find(t, ~best[1]);
  }
};

/// The particles that a sum runs over.
struct Members {
  Particles p;
  const std::uint64_t* weight;
  BinTable t;
  const StepState* state;
  PARLOC_HD bool in_cluster(std::size_t i) const { return bin_root(t, t.slot_of[i]) == state->best_slot; }
};

struct MeanTerm {
  Members of;
  PARLOC_HD SumVector<kMeanSums> operator()(std::size_t i) const {
    const Particles& p = of.p;
    return mean_terms(p.x[i], p.y[i], p.theta[i], of.weight[i], of.in_cluster(i));
  }
};

struct CovarianceTerm {
  Members of;
  PARLOC_HD SumVector<kCovarianceSums> operator()(std::size_t i) const {
    const Particles& p = of.p;
    return covariance_terms(p.x[i], p.y[i], p.theta[i], of.weight[i], of.in_cluster(i), of.state->all,
                            of.state->cluster);
  }
};

struct Finish {
  BinTable t;
  const double* sums;
  StepState* state;
  bool covariance;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    const double total = static_cast<double>(state->total);
    const double cluster = static_cast<double>(t.weight[state->best_slot]);
    if (covariance) {
      finish_covariance(state->all, sums, total);
      finish_covariance(state->cluster, sums + 6, cluster);
    } else {
      finish_mean(state->all, sums, total, total);
      finish_mean(state->cluster, sums + 4, cluster, total);
    }
  }
};

}  // namespace

void FilterStages::clear_bins(const BinTable& t, Queue& queue) {
  launch(ClearAllBins{t}, blocks_for(t.capacity), queue);
}

void clear_used_bins(const BinTable& t, std::size_t most, Queue& queue) {
  launch(ClearBins{t}, blocks_for(most), queue);
  launch(ClearList{t}, 1, queue);
}

void FilterStages::estimate(const EstimateArgs& args, Queue& queue) {
  const Particles& p = args.particles;
  const BinTable& t = args.bins;
  StepState* const state = args.state;
  const std::uint64_t* weight = args.weights.weight;
  const unsigned blocks = blocks_for(p.capacity);  // there are no more bins than particles
  std::uint64_t* best = queue.scratch.best.data();
  launch(FillBins{t, p, weight, best}, blocks, queue);
  launch(JoinBins{t}, blocks, queue);
  launch(SumClusters{t}, blocks, queue);
  launch(FindHeaviest{t, best, false}, blocks, queue);
  launch(FindHeaviest{t, best, true}, blocks, queue);
  launch(TakeHeaviest{t, best, state}, 1, queue);
  const Members members{p, weight, t, state};
  const double* mean = block_sum<kMeanSums>(p, MeanTerm{members}, queue.scratch.sums.data(), queue);
  launch(Finish{t, mean, state, false}, 1, queue);
  const double* cov =
      block_sum<kCovarianceSums>(p, CovarianceTerm{members}, queue.scratch.sums.data(), queue);
  launch(Finish{t, cov, state, true}, 1, queue);
  clear_used_bins(t, p.capacity, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
