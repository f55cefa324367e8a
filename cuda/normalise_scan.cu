#include "common/filter/normalise.h"

#if defined(__CUDACC__)
#include <cub/device/device_scan.cuh>
#endif

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

void inclusive_scan(const std::uint64_t* in, std::uint64_t* out, std::size_t count, Scratch& scratch,
                    Stream stream) {
#if defined(__CUDACC__)
  std::size_t bytes = scratch.scan.size();
  PARLOC_CHECK(
      cub::DeviceScan::InclusiveSum(scratch.scan.data(), bytes, in, out, static_cast<int>(count), stream),
      "scanning weights");
#else
  (void)scratch;
  submit(stream, [=] {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) out[i] = (sum += in[i]);
  });
#endif
}

void Scratch::reserve(std::size_t particles) {
  const std::size_t blocks = sum_blocks(particles);
  sums.reserve((blocks + sum_blocks(blocks) + 3) * 12);  // the widest sum has 12 terms
  best.reserve(2);
#if defined(__CUDACC__)
  std::size_t bytes = 0;
  std::uint64_t* none = nullptr;
  PARLOC_CHECK(cub::DeviceScan::InclusiveSum(nullptr, bytes, none, none, static_cast<int>(particles)),
               "sizing the scan");
  scan.reserve(bytes > 0 ? bytes : 1);
#endif
}

void normalise_scan(const NormaliseArgs& a, Scratch& scratch, Stream stream) {
  const std::size_t count = a.particles.capacity;
  launch(ClearMax{a.state}, 1, stream);
  launch(FindMax{a}, std::min(blocks_for(count), 1024u), stream);
  launch(TakeMax{a.state}, 1, stream);
  launch(Normalise{a, weight_bits(count)}, blocks_for(count), stream);
  inclusive_scan(a.weights.weight, a.weights.cumulative, count, scratch, stream);
  const double* squares =
      block_sum<1>(a.particles, SquareTerm{a.weights.weight}, scratch.sums.data(), stream);
  launch(Decide{a, squares}, 1, stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
