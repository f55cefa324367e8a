#include "common/eval/spread.h"

#include <utility>

#include "common/math/quantile.h"

namespace parloc {

Spread spread_of(std::vector<double> values) {
  const std::vector<double> sorted = ascending(std::move(values));
  return {sorted.size(), median(sorted), nearest_rank(sorted, 95), nearest_rank(sorted, 100)};
}

/// The time that `rank` others are not above, from 0 on.
double TimeTally::ranked_ms(std::uint64_t rank) const {
  std::uint32_t place = 0;
  for (std::uint64_t below = counts_[0]; below <= rank && place + 1 < SampleMark::kTimes;)
    below += counts_[++place];
  return SampleMark::time_ms_at(place);
}

Spread TimeTally::spread_ms() const {
  if (count_ == 0) return spread_of({});
  const double middle_ms = 0.5 * (ranked_ms((count_ - 1) / 2) + ranked_ms(count_ / 2));
  return {count_, middle_ms, ranked_ms((95 * count_ + 99) / 100 - 1), ranked_ms(count_ - 1)};
}

}  // namespace parloc
