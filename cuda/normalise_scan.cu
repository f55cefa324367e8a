#include "common/filter/normalise.h"

#include "cuda/block_sum.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// A float as an integer of the same order, so that an integer maximum can be taken.
PARLOC_HD std::uint32_t ordered(float x) {
  const std::uint32_t b = bits_of(x);
  return (b >> 31) != 0 ? ~b : b | 0x80000000u;
}
PARLOC_HD float from_ordered(std::uint32_t o) {
  return float_of((o >> 31) != 0 ? o & 0x7fffffffu : ~o);
}

struct ClearMax {
  StepState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) state->best_slot = ordered(kNoWeight);  // holds the maximum until take_max
  }
};

struct FindMax {
  struct Shared {
    std::uint32_t most;
  };
  static constexpr int kPhases = 3;
  NormaliseArgs a;
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (phase == 0 && me.thread == 0) s.most = ordered(kNoWeight);
    if (phase == 1) {
      float most = kNoWeight;
      for (std::size_t i = me.first(); i < a.particles.count(); i += me.stride())
        most = max_of(valid_log_weight(a.particles.log_weight[i]), most);
      atomic_raise(&s.most, ordered(most));
    }
    if (phase == 2 && me.thread == 0) atomic_raise(&a.state->best_slot, s.most);
  }
};

struct TakeMax {
  StepState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    state->max_log_weight = from_ordered(state->best_slot);
    state->degenerate = state->max_log_weight == kNoWeight ? 1 : 0;
  }
};

struct Normalise {
  NormaliseArgs a;
  int bits;
  PARLOC_HD void operator()(const Thread& me) const {
    const StepState now = *a.state;
    const std::size_t count = a.particles.count();
    for (std::size_t i = me.first(); i < a.particles.capacity; i += me.stride())  // the scan reads them all
      a.weights.weight[i] = i < count ? normalise_one(a.particles.log_weight[i], now, bits) : 0;
  }
};

struct SquareTerm {
  const std::uint64_t* weight;
  PARLOC_HD SumVector<1> operator()(std::size_t i) const {
    const double q = static_cast<double>(weight[i]);
    return {{q * q}};
  }
};

struct Decide {
  NormaliseArgs a;
  const double* squares;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    finish_normalising(a, a.weights.cumulative[a.particles.count() - 1], *squares);
  }
};

}  // namespace

void FilterStages::normalise_scan(const NormaliseArgs& a, Queue& queue) {
  const std::size_t count = a.particles.capacity;
  launch(ClearMax{a.state}, 1, queue);
  launch(FindMax{a}, std::min(blocks_for(count), 1024u), queue);
  launch(TakeMax{a.state}, 1, queue);
  launch(Normalise{a, weight_bits(count)}, blocks_for(count), queue);
  inclusive_scan(a.weights.weight, a.weights.cumulative, count, queue);
  const double* squares =
      block_sum<1>(a.particles, SquareTerm{a.weights.weight}, queue.scratch.sums.data(), queue);
  launch(Decide{a, squares}, 1, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
