// Where the stages of one engine are started: a stream on a device, and scratch memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "cuda/launch.h"
#include "cuda/memory.h"

namespace parloc {
class FilterGroup;
}

namespace parloc::PARLOC_CUDA_NAMESPACE {

class StepGroup;

/// The largest log-weight: as it is found, in the order of unsigned integers, and then for who asks.
struct LargestWeight {
  static constexpr std::uint32_t kNone = 0x007fffffu;  // -inf
  std::uint32_t so_far = kNone;                        // kNone between kernels
  float log_weight = 0.0f;
};

/// Blocks that look for the heaviest cluster.
constexpr unsigned kHeaviestBlocks = 128;

/// Of the collective stages, sized once for a particle count.
struct Scratch {
  DeviceBuffer<double> sums;
  DeviceBuffer<std::uint64_t> before;   // what comes before each block of a scan
  DeviceBuffer<std::uint32_t> arrived;  // [1] Blocks that are done; zero between kernels
  DeviceBuffer<LargestWeight> largest;  // [1]
  DeviceBuffer<std::uint64_t>
      heaviest;                        // [kHeaviestBlocks][2] weight, key; and [1] the weight of the heaviest
  DeviceBuffer<std::uint64_t> first;   // adapt: [N] candidates that are the first in their bin, ...
  DeviceBuffer<std::uint64_t> enough;  // ... and [1] the earliest by which there are enough
  DeviceBuffer<char> lists;            // of Thrust (cuda/lists.h)
};

class Queue {
 public:
  /// Throws Error{backend} if there is no such device, or the group is on another.
  explicit Queue(int device, const std::shared_ptr<FilterGroup>& group = nullptr);
  static Queue open(int /*threads*/, int device, const std::shared_ptr<FilterGroup>& group = nullptr) {
    return Queue(device, group);
  }
  ~Queue() { free_stream(stream_); }
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// Every later call of this host thread is meant for this device: a thread may drive several engines.
  void use() const { select_device(device_); }
  void wait() const { synchronise(stream_); }
  /// Scratch for every stage on so many particles.
  void reserve(std::size_t particles);
  operator Stream() const { return stream_; }
  /// With which steps are done; may be null.
  StepGroup* group() const { return group_.get(); }
  std::string name() const { return "cuda (" + device_name_ + ")"; }

  Scratch scratch;

 private:
  int device_;
  std::string device_name_;
  std::shared_ptr<StepGroup> group_;
  Stream stream_{};
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
