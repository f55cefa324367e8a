#include "common/filter/resampling.h"

#include "cpu/scan.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

void residual_sums(const ResampleArgs& a, Workers& workers) {
  const std::uint64_t n = a.from.count;
  const std::uint64_t total = a.state->total;
  const std::uint64_t* weight = a.weights.weight;
  const int shift = remainder_shift(n, total);
  inclusive_scan(n, workers, a.offspring_sum,
                 [=](std::size_t i) PARLOC_SIMD_LOOP { return whole_copies(weight[i], n, total); });
  inclusive_scan(n, workers, a.remainder_sum,
                 [=](std::size_t i) PARLOC_SIMD_LOOP { return left_over(weight[i], n, total, shift); });
}

}  // namespace

void resample(const ResampleArgs& a, Workers& workers) {
  if (a.state->resample != 0 && a.scheme == ResampleScheme::residual) residual_sums(a, workers);
  parallel_for(a.from.count, workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t j = begin; j < end; ++j) {
      const std::uint32_t from = ancestor_of(a, j);
      a.ancestor[j] = from;
      gather_one(a, j, from);
    }
  });
}

}  // namespace parloc::cpu
