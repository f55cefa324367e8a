// Median, 95th percentile and maximum of many values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/eval/sample_mark.h"

namespace parloc {

/// Of some values; all NaN without one.
struct Spread {
  std::size_t count = 0;
  double median = 0.0;  ///< The mean of the middle two of an even count.
  double p95 = 0.0;     ///< Nearest rank: 95 % are at or below it.
  double most = 0.0;
};
Spread spread_of(std::vector<double> values);

/// Of times, in memory that does not grow: to 0.1 % (SampleMark), and so the same whatever the order.
class TimeTally {
 public:
  void add(SampleMark mark) { ++counts_[mark.time_place()], ++count_; }
  Spread spread_ms() const;

 private:
  double ranked_ms(std::uint64_t rank) const;

  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(SampleMark::kTimes, 0);
  std::uint64_t count_ = 0;
};

}  // namespace parloc
