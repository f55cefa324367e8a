#include "common/filter/weights/moments.h"

#include "cuda/block_sum.h"
#include "cuda/fill_bins.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

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
      const std::uint32_t slot = t.used[k], root = bin_settled_root(t, slot);
      if (root != slot) atomic_add(&t.weight[root], t.weight[slot]);
    }
  }
};

/// A cluster by its weight and its root's key: the heavier is better, of equals the one with the smaller key.
struct Cluster {
  std::uint64_t weight, key;
  PARLOC_HD bool better_than(const Cluster& other) const {
    return weight > other.weight || (weight == other.weight && key < other.key);
  }
};

/// Of all clusters the best: by blocks, and then the last block of what they have found.
struct FindHeaviest {
  struct Shared {
    Cluster best[kThreads];
    bool last;
  };
  static constexpr int kHalvings = 8, kJoin = 2 + kHalvings, kPhases = kJoin + 2 + kHalvings;
  BinTable t;
  std::uint64_t* heaviest;  // Scratch::heaviest
  StepState* state;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return kJoin; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (phase == 0) s.best[me.thread] = best_root(me);
    if (phase == kJoin) s.best[me.thread] = best_of_blocks(me);
    const int halving = (phase < kJoin ? phase : phase - kJoin) - 1;
    if (halving >= 0 && halving < kHalvings) return halve(me.thread, halving, s);
    if (halving != kHalvings || me.thread > 0) return;
    if (phase < kJoin) {
      heaviest[2 * me.block] = s.best[0].weight;
      heaviest[2 * me.block + 1] = s.best[0].key;
    } else {
      heaviest[2 * kHeaviestBlocks] = s.best[0].weight;
      state->best_slot = bin_find(t, s.best[0].key);
    }
  }

 private:
  PARLOC_HD Cluster best_root(const Thread& me) const {
    Cluster best{0, kNoBin};
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) {
      const std::uint32_t slot = t.used[k];
      if (t.parent[slot] != slot) continue;
      const Cluster here{t.weight[slot], t.key[slot]};
      if (here.better_than(best)) best = here;
    }
    return best;
  }
  PARLOC_HD Cluster best_of_blocks(const Thread& me) const {
    if (me.thread >= me.blocks) return {0, kNoBin};
    return {heaviest[2 * me.thread], heaviest[2 * me.thread + 1]};
  }
  PARLOC_HD static void halve(unsigned t, int halving, Shared& s) {
    const unsigned offset = (kThreads / 2) >> halving;
    if (t < offset && s.best[t + offset].better_than(s.best[t])) s.best[t] = s.best[t + offset];
  }
};
static_assert(kHeaviestBlocks <= kThreads);

/// Notes of each particle whether it is in the heaviest cluster, in place of its slot.
struct MeanTerm {
  Particles p;
  const std::uint64_t* weight;
  BinTable t;
  const StepState* state;
  PARLOC_HD SumVector<kMeanSums> operator()(std::size_t i) const {
    const bool in_cluster = bin_settled_root(t, t.slot_of[i]) == state->best_slot;
    t.slot_of[i] = in_cluster ? 1 : 0;
    return mean_terms(p.x[i], p.y[i], p.theta[i], weight[i], in_cluster);
  }
};

struct FinishMean {
  const std::uint64_t* heaviest;
  StepState* state;
  PARLOC_HD void operator()(const double* sums) const {
    const double total = static_cast<double>(state->total);
    const double cluster = static_cast<double>(*heaviest);
    finish_mean(state->all, sums, total, total);
    finish_mean(state->cluster, sums + 4, cluster, total);
  }
};

/// Needs the bins no more, so that they are emptied beside it.
struct CovarianceTerm {
  Particles p;
  const std::uint64_t* weight;
  BinTable t;
  const StepState* state;
  PARLOC_HD SumVector<kCovarianceSums> operator()(std::size_t i) const {
    return covariance_terms(p.x[i], p.y[i], p.theta[i], weight[i], t.slot_of[i] != 0, state->all,
                            state->cluster);
  }
  PARLOC_HD void beside(const Thread& me) const {
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) bin_clear(t, t.used[k]);
  }
};

struct FinishCovariance {
  const std::uint64_t* heaviest;
  StepState* state;
  std::uint64_t* used_count;
  PARLOC_HD void operator()(const double* sums) const {
    finish_covariance(state->all, sums, static_cast<double>(state->total));
    finish_covariance(state->cluster, sums + 6, static_cast<double>(*heaviest));
    *used_count = 0;
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

}  // namespace

void FilterStages::clear_bins(const BinTable& t, Queue& queue) {
  launch(ClearAllBins{t}, blocks_for(t.capacity), queue);
}

void FilterStages::estimate(const EstimateArgs& args, Queue& queue) {
  const Particles& p = args.particles;
  const BinTable& t = args.bins;
  StepState* const state = args.state;
  const std::uint64_t* weight = args.weights.weight;
  std::uint64_t* const heaviest = queue.scratch.heaviest.data();
  const std::uint64_t* const weight_of_heaviest = heaviest + 2 * kHeaviestBlocks;
  const unsigned blocks = blocks_for(p.capacity);  // there are no more bins than particles
  launch(FillBins{t, p, weight}, blocks_to_fill_bins(p.capacity), queue);
  launch(JoinBins{t}, blocks, queue);
  launch(SumClusters{t}, blocks, queue);
  launch(FindHeaviest{t, heaviest, state, queue.scratch.arrived.data()}, std::min(blocks, kHeaviestBlocks),
         queue);
  block_sum<kMeanSums>(p, MeanTerm{p, weight, t, state}, FinishMean{weight_of_heaviest, state}, queue);
  block_sum<kCovarianceSums>(p, CovarianceTerm{p, weight, t, state},
                             FinishCovariance{weight_of_heaviest, state, t.used_count}, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
