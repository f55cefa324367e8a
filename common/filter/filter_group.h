// Many particle filters on one CUDA device at once.
#pragma once

#include <cstdint>
#include <memory>

#include "common/filter/steps/compute_config.h"

namespace parloc {

/// How often filters have stepped, and in how many goes.
struct FilterGroupCounts {
  std::uint64_t steps = 0;    ///< Of all filters together.
  std::uint64_t batches = 0;  ///< Goes in which these were done.
};

/// Filters that are given one group start the kernels of their steps together: one launch does the work of
/// all that are ready, where each alone would leave most of the device idle. Filters that are ready are those
/// whose threads have asked for a step while the device was busy: nobody waits for a filter that does not
/// step, and filters may differ in everything, come, leave and fail at any time. Those whose steps are of one
/// kind (sensor model, resampling, whether their number adapts) share launches. Results are those of each
/// filter alone, to the bit. Thread-safe: each filter belongs to one thread at a time, the group to all.
class FilterGroup {
 public:
  virtual ~FilterGroup() = default;
  /// Since the group was made.
  virtual FilterGroupCounts counts() const = 0;
};

/// For FilterConfig::group; null where filters have nothing to share, on the CPU. Throws Error{backend} if
/// there is no such device.
std::shared_ptr<FilterGroup> make_filter_group(const ComputeConfig& compute);

/// Defined in cuda/engines.cu.
std::shared_ptr<FilterGroup> make_cuda_filter_group(int device);

}  // namespace parloc
