// OpenMP loop over the blocks of a fixed-shape sum (common/math/block_sum.h).
#pragma once

#include "common/math/block_sum.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

/// K sums of term(i) for i < count, in the fixed shape. workers.sums holds the block sums.
template <int K, class Term>
SumVector<K> block_sum(std::size_t count, Workers& workers, const Term& term) {
  std::size_t blocks = sum_blocks(count);
  workers.sums.resize((blocks + sum_blocks(blocks) + 1) * K);  // three levels reach 2^30 elements
  double* level = workers.sums.data();
  parallel_blocks(blocks, count < kSmallLoop ? 1 : workers.threads, 1,
                  [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                    for (std::size_t b = begin; b < end; ++b) {
                      const SumVector<K> s = sum_one_block<K>(b, count, term);
                      for (int k = 0; k < K; ++k) level[b * K + k] = s.v[k];
                    }
                  });
  while (blocks > 1) {
    double* next = level + blocks * K;
    const std::size_t above = sum_blocks(blocks);
    for (std::size_t b = 0; b < above; ++b) {
      const SumVector<K> s = sum_one_block<K>(b, blocks, [=](std::size_t i) PARLOC_SIMD_LOOP {
        SumVector<K> x;
        for (int k = 0; k < K; ++k) x.v[k] = level[i * K + k];
        return x;
      });
      for (int k = 0; k < K; ++k) next[b * K + k] = s.v[k];
    }
    level = next;
    blocks = above;
  }
  SumVector<K> out;
  for (int k = 0; k < K; ++k) out.v[k] = count > 0 ? level[k] : 0.0;
  return out;
}

}  // namespace parloc::cpu
