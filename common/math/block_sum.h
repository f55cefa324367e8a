// Sums of float64 in a fixed shape (SPEC 0.7, D256): blocks of 1024 elements; lane t of 256 adds elements t,
// t + 256, t + 512, t + 768 in that order; a tree with offsets 128 to 1; block sums added the same way.
// Missing elements add exactly 0. The shape, and so the bits, do not depend on who computes which block.
#pragma once

#include <cstddef>

#include "common/math/host_device.h"

namespace parloc {

constexpr std::size_t kSumBlock = 1024;
constexpr std::size_t kSumLanes = 256;

PARLOC_HD std::size_t sum_blocks(std::size_t count) {
  return (count + kSumBlock - 1) / kSumBlock;
}

/// Values of K sums.
template <int K>
struct SumVector {
  double v[K];
};

/// One block on one thread: K sums of term(i) (a SumVector<K>) over the block's elements below `count`.
template <int K, class Term>
PARLOC_HD SumVector<K> sum_one_block(std::size_t block, std::size_t count, const Term& term) {
  double lane[K][kSumLanes] = {};
  const std::size_t first = block * kSumBlock;
  for (std::size_t row = 0; row < kSumBlock / kSumLanes; ++row) {
    const std::size_t begin = first + row * kSumLanes;
    const std::size_t here = begin >= count ? 0 : (count - begin < kSumLanes ? count - begin : kSumLanes);
    for (std::size_t t = 0; t < here; ++t) {
      const SumVector<K> x = term(begin + t);
      for (int k = 0; k < K; ++k) lane[k][t] += x.v[k];
    }
  }
  for (std::size_t offset = kSumLanes / 2; offset > 0; offset /= 2)
    for (int k = 0; k < K; ++k)
      for (std::size_t t = 0; t < offset; ++t) lane[k][t] += lane[k][t + offset];
  SumVector<K> out;
  for (int k = 0; k < K; ++k) out.v[k] = lane[k][0];
  return out;
}

}  // namespace parloc
