#include "common/filter/weights/moments.h"

#include "cuda/block_sum.h"
#include "cuda/fill_bins.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct JoinBins {
  BinTable t;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t pairs = *t.used_count * kBinNeighbours;
    for (std::size_t k = me.first(); k < pairs; k += me.stride())
      bin_join_neighbour(t, t.used[k / kBinNeighbours], static_cast<std::uint32_t>(k % kBinNeighbours));
  }
};

/// A cluster by its weight and its root's key: the heavier is better, of equals the one with the smaller key.
struct Cluster {
  std::uint64_t weight, key;
  PARLOC_HD bool better_than(const Cluster& other) const {
    return weight > other.weight || (weight == other.weight && key < other.key);
  }
};

/// Adds the bins of a cluster to its root, and finds the best of all clusters. A root only ever gets heavier,
/// and whoever adds to it sees what it has become: the heaviest that anybody sees is a root with all its
/// bins.
struct SumClusters {
  struct Shared {
    Cluster best[kThreads];
    std::uint64_t weight, key_below;  // the heaviest; ~key, so that the smallest key is the largest
    bool last;
  };
  static constexpr int kJoin = 4, kPhases = 2 * kJoin;  // the best of a block, then of all blocks
  BinTable t;
  std::uint64_t* heaviest;  // Scratch::heaviest
  StepState* state;
  std::uint32_t* arrived;

  PARLOC_HD int join_phase() const { return kJoin; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    Cluster& best = s.best[me.thread];
    const int part = phase % kJoin;
    if (part == 0) {
      best = phase < kJoin ? add_up(me) : best_of_block(me);
      if (me.thread == 0) s.weight = s.key_below = 0;
    }
    if (part == 1 && best.weight > atomic_read(&s.weight)) atomic_raise(&s.weight, best.weight);
    if (part == 2 && best.weight == s.weight) atomic_raise(&s.key_below, ~best.key);
    if (part < 3 || me.thread > 0) return;
    std::uint64_t* const to = heaviest + 2 * (phase < kJoin ? me.block : kHeaviestBlocks);
    to[0] = s.weight;
    if (phase < kJoin)
      to[1] = ~s.key_below;
    else
      state->best_slot = bin_find(t, ~s.key_below);
  }

 private:
  PARLOC_HD Cluster add_up(const Thread& me) const {
    Cluster best{0, kNoBin};
    for (std::size_t k = me.first(); k < *t.used_count; k += me.stride()) {
      const std::uint32_t slot = t.used[k], root = bin_settled_root(t, slot);
      const std::uint64_t more = root != slot ? t.weight[slot] : 0;
      const Cluster here{atomic_add(&t.weight[root], more) + more, t.key[root]};
      if (here.better_than(best)) best = here;
    }
    return best;
  }
  PARLOC_HD Cluster best_of_block(const Thread& me) const {
    if (me.thread >= me.blocks) return {0, kNoBin};
    return {heaviest[2 * me.thread], heaviest[2 * me.thread + 1]};
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
  /// Two threads of one warp, side by side.
  PARLOC_HD void operator()(unsigned t, const double* sums) const {
    if (t >= 2) return;
    const double total = static_cast<double>(state->total);
    finish_mean(t == 0 ? state->all : state->cluster, sums + 4 * t,
                t == 0 ? total : static_cast<double>(*heaviest), total);
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
  PARLOC_HD void operator()(unsigned t, const double* sums) const {
    if (t >= 2) return;
    finish_covariance(t == 0 ? state->all : state->cluster, sums + 6 * t,
                      static_cast<double>(t == 0 ? state->total : *heaviest));
    if (t == 0) *used_count = 0;
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
  fill_bins(t, p, weight, queue);
  launch_step(JoinBins{t}, blocks, queue);
  launch_step(SumClusters{t, heaviest, state, queue.scratch.arrived.data()},
              std::min(blocks, kHeaviestBlocks), queue);
  block_sum<kMeanSums>(p, MeanTerm{p, weight, t, state}, FinishMean{weight_of_heaviest, state}, queue);
  block_sum<kCovarianceSums>(p, CovarianceTerm{p, weight, t, state},
                             FinishCovariance{weight_of_heaviest, state, t.used_count}, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
