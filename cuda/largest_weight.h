// The largest log-weight of all particles: an integer maximum over the blocks of a kernel.
#pragma once

#include "common/filter/weights/normalise.h"
#include "common/math/atomics.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// A float as an integer of the same order.
PARLOC_HD std::uint32_t ordered(float x) {
  const std::uint32_t b = bits_of(x);
  return (b >> 31) != 0 ? ~b : b | 0x80000000u;
}
PARLOC_HD float from_ordered(std::uint32_t o) {
  return float_of((o >> 31) != 0 ? o & 0x7fffffffu : ~o);
}

/// Every block enters its largest; the last block takes the largest of these, and leaves the place empty.
struct LargestOfBlocks {
  LargestWeight* there;
  PARLOC_HD void enter(std::uint32_t largest) const { atomic_raise(&there->so_far, largest); }
  PARLOC_HD void take() const {
    there->log_weight = from_ordered(there->so_far);
    there->so_far = LargestWeight::kNone;
  }
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
