// What one particle's beams add to its log-weight by a ray model: loops of a fixed length over beams side by
// side, which the compiler turns into vectors without a rest.
#pragma once

#include <algorithm>
#include <numeric>
#include <span>

#include "common/math/fixed_point.h"
#include "cpu/ray_trace.h"
#include "cpu/simd.h"

namespace parloc::cpu {

constexpr std::size_t kMostLooks = 8;
constexpr std::size_t kFirstBeams =
    64;  // after which a particle is looked at; then after twice as many each time
constexpr std::int32_t kTogether =
    16;  // beams that are weighed together: loops of a fixed length need no rest

/// A scan as a ray model weighs it: copies of the beams' values, so that loops may run a little past their
/// end; and the most that beams can add to a particle's sum, whatever it expects.
template <class Model>
class RayScan {
 public:
  RayScan(const Model& model, const Beams& b) : model_(model), hits_(b.hits), count_(b.count) {
    std::copy_n(b.range_m, count_, range_m_);
    std::copy_n(b.short_density, count_, constant_);
    for (std::size_t m = 0; m < count_; ++m)
      most_[m] = fixed_log_likelihood(m < hits_ ? model.most_of_hit(range_m_[m], constant_[m])
                                                : model.most_of_miss());
    for (std::size_t last = 0, more = kFirstBeams; last < count_; more *= 2) {
      last = std::min(last + more, count_);
      looks_[looks_count_++] = {last, std::accumulate(most_ + last, most_ + count_, std::int64_t{0})};
    }
  }

  /// When to look whether a particle can still win: after so many beams, and the most that the others can
  /// add.
  struct Look {
    std::size_t last;
    std::int64_t most_behind;
  };
  std::span<const Look> looks() const { return {looks_, looks_count_}; }

  /// Sum over beams [first, last). A range that is not known yet counts as the best one.
  PARLOC_HD std::int64_t sum(const float* expected_m, std::size_t first, std::size_t last) const {
    LaneSums sums;
    for (std::size_t at = first; at < last; at += kTogether) {
      const std::int32_t end = static_cast<std::int32_t>(last - at);
      const std::int32_t hits = static_cast<std::int32_t>(hits_) - static_cast<std::int32_t>(at);
      if (hits > 0) add_beams<true>(sums, at, expected_m, 0, hits < end ? hits : end);
      if (hits < kTogether) add_beams<false>(sums, at, expected_m, hits, end);
    }
    return sums.total();
  }

  /// What sum() lacks of beams whose ranges have become known since. `place`: of their ranges in the rows,
  /// kTogether more than `count`; those behind it may be of any particle.
  PARLOC_HD std::int64_t late_sum(const float* expected_m, std::size_t row, const std::int32_t* place,
                                  std::size_t count) const {
    const std::int32_t first = static_cast<std::int32_t>(row), hits = static_cast<std::int32_t>(hits_);
    LaneSums now, before;
    for (std::size_t at = 0; at < count; at += kTogether, place += kTogether) {
      const std::int32_t end = static_cast<std::int32_t>(count - at);
      LateBeams b;
      std::int32_t misses = 0;
      for (std::int32_t k = 0; k < kTogether; ++k) {
        const std::int32_t m = (place[k] - first) & all_if(k < end);
        b.beam[k] = m;
        b.range_m[k] = range_m_[m], b.constant[k] = constant_[m], b.expected_m[k] = expected_m[first + m];
        before.add(k, most_[m] & all_if(k < end));
        misses |= all_if(m >= hits);
      }
      add_late<true>(now, b, end);
      if (misses != 0) add_late<false>(now, b, end);
    }
    return now.total() - before.total();
  }

 private:
  /// Sums side by side, in halves that 32 bits hold for as many beams as there can be.
  struct LaneSums {
    alignas(64) std::int32_t high[kTogether] = {};
    alignas(64) std::int32_t low[kTogether] = {};
    PARLOC_HD void add(std::int32_t k, std::int32_t value) {
      high[k] += value >> 16;
      low[k] += value & 0xffff;
    }
    PARLOC_HD std::int64_t total() const {
      std::int32_t h = 0, l = 0;
      for (std::int32_t k = 0; k < kTogether; ++k) h += high[k], l += low[k];
      return std::int64_t{h} * 65536 + l;
    }
  };
  static_assert(kFirstBeams << kMostLooks > kMaxBeams);
  static_assert(kMaxBeams * 32768 <= 0x7fffffff && kMaxBeams * 65535 / kTogether <= 0x7fffffff);

  /// Masks, not choices, which would keep the loops out of vectors.
  PARLOC_HD static std::int32_t all_if(bool condition) { return -static_cast<std::int32_t>(condition); }

  struct LateBeams {
    std::int32_t beam[kTogether];
    float range_m[kTogether], constant[kTogether], expected_m[kTogether];
  };

  template <bool kHit>
  PARLOC_HD std::int32_t value(float range_m, float constant, float expected_m) const {
    return fixed_log_likelihood(kHit ? model_.hit(range_m, constant, expected_m)
                                     : model_.miss(range_m, expected_m));
  }
  /// Of beams at + [from, to).
  template <bool kHit>
  PARLOC_HD void add_beams(LaneSums& sums, std::size_t at, const float* expected_m, std::int32_t from,
                           std::int32_t to) const {
    const float *range_m = range_m_ + at, *constant = constant_ + at, *expected = expected_m + at;
    const std::int32_t* most = most_ + at;
    for (std::int32_t k = 0; k < kTogether; ++k) {
      const std::int32_t known = all_if(expected[k] >= 0.0f);
      const std::int32_t v = (value<kHit>(range_m[k], constant[k], expected[k]) & known) | (most[k] & ~known);
      sums.add(k, v & all_if(k >= from) & all_if(k < to));
    }
  }
  /// Of those of the first `end` that hit something, or did not.
  template <bool kHit>
  PARLOC_HD void add_late(LaneSums& sums, const LateBeams& b, std::int32_t end) const {
    const std::int32_t hits = static_cast<std::int32_t>(hits_);
    for (std::int32_t k = 0; k < kTogether; ++k) {
      const std::int32_t v = value<kHit>(b.range_m[k], b.constant[k], b.expected_m[k]);
      sums.add(k, v & all_if((b.beam[k] < hits) == kHit) & all_if(k < end));
    }
  }

  const Model model_;
  const std::size_t hits_, count_;
  alignas(64) float range_m_[kRangeRoom] = {};
  alignas(64) float constant_[kRangeRoom] = {};
  alignas(64) std::int32_t most_[kRangeRoom] = {};
  Look looks_[kMostLooks];
  std::size_t looks_count_ = 0;
};

}  // namespace parloc::cpu
