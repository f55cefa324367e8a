// Sums over the beams of a scan in a fixed shape (SPEC 0.7, S32): lane l of 32 adds the terms l, l + 32, ...
// in that order, then lanes are folded with offsets 16 to 1. The shape, and so the bits, do not depend on who
// adds: a warp of a GPU, or vectors of a CPU.
#pragma once

#include <cstddef>

#include "common/math/host_device.h"

namespace parloc {

constexpr std::size_t kBeamLanes = 32;

/// Terms of one beam, or their sums over a scan.
template <int K>
struct BeamTerms {
  static constexpr int kCount = K;
  float v[K];
};

/// The sums of each lane.
template <int K>
struct LaneSums {
  float lane[K][kBeamLanes];

  PARLOC_HD void clear(std::size_t l) {
    for (int k = 0; k < K; ++k) lane[k][l] = 0.0f;
  }
  PARLOC_HD void add(std::size_t l, const BeamTerms<K>& terms) {
    for (int k = 0; k < K; ++k) lane[k][l] += terms.v[k];
  }
  /// Of one lane below `offset`: it takes over its partner.
  PARLOC_HD void fold(std::size_t l, std::size_t offset) {
    for (int k = 0; k < K; ++k) lane[k][l] += lane[k][l + offset];
  }
  /// What is left in lane 0 after all folds.
  PARLOC_HD BeamTerms<K> total() const {
    BeamTerms<K> sum;
    for (int k = 0; k < K; ++k) sum.v[k] = lane[k][0];
    return sum;
  }
  /// All folds, on one thread.
  PARLOC_HD BeamTerms<K> fold_all() {
    for (std::size_t offset = kBeamLanes / 2; offset > 0; offset /= 2)
      for (std::size_t l = 0; l < offset; ++l) fold(l, offset);
    return total();
  }
};

}  // namespace parloc
