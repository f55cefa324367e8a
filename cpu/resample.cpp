#include "common/filter/resampling.h"

#include "cpu/scan.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

void residual_sums(const ResampleArgs& a, Workers& workers) {
  const std::size_t parents = a.from.count();
  const std::uint64_t n = a.to.count();
  const std::uint64_t total = a.state->total;
  const std::uint64_t* weight = a.weights.weight;
  const int shift = remainder_shift(n, total);
  inclusive_scan(parents, workers, a.offspring_sum,
                 [=](std::size_t i) PARLOC_SIMD_LOOP { return whole_copies(weight[i], n, total); });
  inclusive_scan(parents, workers, a.remainder_sum,
                 [=](std::size_t i) PARLOC_SIMD_LOOP { return left_over(weight[i], n, total, shift); });
}

/// stratum(j, r, n) for j = first, first + 1, ...: by addition, with the remainder carried along.
class Strata {
 public:
  Strata(std::uint64_t first, std::uint64_t r, std::uint64_t n) : n_(n) {
    const unsigned __int128 start = (static_cast<unsigned __int128>(first) << 64) + r;
    const unsigned __int128 width = static_cast<unsigned __int128>(1) << 64;
    at_ = static_cast<std::uint64_t>(start / n);
    remainder_ = static_cast<std::uint64_t>(start % n);
    step_ = static_cast<std::uint64_t>(width / n);
    step_remainder_ = static_cast<std::uint64_t>(width % n);
  }
  std::uint64_t next() {
    const std::uint64_t now = at_;
    remainder_ += step_remainder_;
    const bool carry = remainder_ >= n_;
    at_ += step_ + (carry ? 1 : 0);
    remainder_ -= carry ? n_ : 0;
    return now;
  }

 private:
  std::uint64_t n_, at_, remainder_, step_, step_remainder_;
};

/// Thresholds grow with the slot: find the first ancestor, then walk. The same ancestors as by bisection.
template <class Threshold>
void walk(const ResampleArgs& a, std::size_t begin, std::size_t end, Threshold threshold_of) {
  const std::uint64_t* cumulative = a.weights.cumulative;
  std::size_t from = first_above(cumulative, a.from.count(), threshold_of(begin));
  a.ancestor[begin] = static_cast<std::uint32_t>(from);
  for (std::size_t j = begin + 1; j < end; ++j) {
    const std::uint64_t threshold = threshold_of(j);
    while (cumulative[from] <= threshold) ++from;
    a.ancestor[j] = static_cast<std::uint32_t>(from);
  }
  for (std::size_t j = begin; j < end; ++j) gather_one(a, j, a.ancestor[j]);
}

void resample_in_order(const ResampleArgs& a, std::size_t begin, std::size_t end) {
  const std::uint64_t n = a.to.count(), total = a.state->total;
  if (a.scheme == ResampleScheme::systematic) {
    Strata strata(begin, word64(philox(0, a.key.step, Stream::systematic, 0, a.key.seed)), n);
    walk(a, begin, end, [&](std::size_t) { return multiply_high(strata.next(), total); });
  } else {
    walk(a, begin, end, [&](std::size_t j) { return draw_threshold(a.scheme, j, n, total, a.key); });
  }
}

bool in_order(const ResampleArgs& a) {
  return a.state->resample != 0 &&
         (a.scheme == ResampleScheme::systematic || a.scheme == ResampleScheme::stratified);
}

}  // namespace

void FilterStages::resample(const ResampleArgs& args, Queue& workers) {
  const ResampleArgs a = with_input(args);
  if (a.state->resample != 0 && a.scheme == ResampleScheme::residual) residual_sums(a, workers);
  const bool ordered = in_order(a);
  const bool injecting = a.state->resample != 0 && a.state->inject > 0.0;
  parallel_for(a.to.count(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    if (ordered) resample_in_order(a, begin, end);
    for (std::size_t j = begin; j < end && !ordered; ++j) {
      const std::uint32_t from = ancestor_of(a, j);
      a.ancestor[j] = from;
      gather_one(a, j, from);
    }
    for (std::size_t j = begin; j < end && injecting; ++j) inject_one(a, static_cast<std::uint32_t>(j));
  });
}

}  // namespace parloc::cpu
