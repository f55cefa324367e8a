#include "common/filter/resampling.h"

#include "cuda/scan.h"
#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct ResidualCounts {
  ResampleArgs a;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint64_t n = a.to.count(), total = a.state->total;
    const int shift = remainder_shift(n, total);
    for (std::size_t i = me.first(); i < a.from.capacity; i += me.stride()) {  // beyond N weights are 0
      a.offspring_sum[i] = whole_copies(a.weights.weight[i], n, total);
      a.remainder_sum[i] = left_over(a.weights.weight[i], n, total, shift);
    }
  }
};

struct Gather {
  ResampleArgs args;
  PARLOC_HD void operator()(const Thread& me) const {
    const ResampleArgs a = with_input(args);
    const std::size_t count = a.to.count();
    const bool injecting = a.state->resample != 0 && a.state->inject > 0.0;
    for (std::size_t j = me.first(); j < count; j += me.stride()) {
      const std::uint32_t from = ancestor_of(a, j);
      a.ancestor[j] = from;
      gather_one(a, j, from);
      if (injecting) inject_one(a, static_cast<std::uint32_t>(j));
    }
  }
};

}  // namespace

void FilterStages::resample(const ResampleArgs& a, Queue& queue) {
  if (a.scheme == ResampleScheme::residual) {
    const std::size_t most = a.from.capacity;
    launch_step(ResidualCounts{a}, blocks_for(most), queue);
    inclusive_scan(a.offspring_sum, most, queue);
    inclusive_scan(a.remainder_sum, most, queue);
  }
  launch_step(Gather{a}, blocks_for(a.to.capacity), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
