#include "common/filter/resampling.h"

#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct ResidualCounts {
  ResampleArgs a;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint64_t n = a.from.count, total = a.state->total;
    const int shift = remainder_shift(n, total);
    for (std::size_t i = me.first(); i < n; i += me.stride()) {
      a.offspring_sum[i] = whole_copies(a.weights.weight[i], n, total);
      a.remainder_sum[i] = left_over(a.weights.weight[i], n, total, shift);
    }
  }
};

struct Gather {
  ResampleArgs args;
  const StepInput* input;
  PARLOC_HD void operator()(const Thread& me) const {
    ResampleArgs a = args;
    a.key = input->key;
    for (std::size_t j = me.first(); j < a.from.count; j += me.stride()) {
      const std::uint32_t from = ancestor_of(a, j);
      a.ancestor[j] = from;
      gather_one(a, j, from);
    }
  }
};

}  // namespace

void resample(const ResampleArgs& a, const StepInput* input, Scratch& scratch, Stream stream) {
  if (a.scheme == ResampleScheme::residual) {
    launch(ResidualCounts{a}, blocks_for(a.from.count), stream);
    inclusive_scan(a.offspring_sum, a.offspring_sum, a.from.count, scratch, stream);
    inclusive_scan(a.remainder_sum, a.remainder_sum, a.from.count, scratch, stream);
  }
  launch(Gather{a, input}, blocks_for(a.from.count), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
