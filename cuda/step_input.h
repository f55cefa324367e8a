// Everything that changes from step to step, in one piece of memory, so that one copy brings it down and the
// kernels of a recorded step find it where it always is.
#pragma once

#include <algorithm>
#include <array>

#include "common/filter/stages.h"
#include "common/model/beams.h"
#include "cuda/memory.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// In device memory. The arrays of the beams lie behind it.
struct alignas(16) StepInput {
  MotionStep motion;
  RandomKey key;
  ScanShape scan;
  RayModels models;  ///< They depend on the maximum range.
  float tempering = 1.0f;
  std::uint32_t all_particles = 0;  ///< adapt: as many as there can be.
  float scan_worth = 0.0f;          ///< Independent beams that the scan counts for; 0: no scan.
};

/// `args` with the scan of this step; the arrays stay where they are.
PARLOC_HD RayTraceArgs with_scan(RayTraceArgs args, const StepInput& input) {
  static_cast<ScanShape&>(args.beams) = input.scan;
  return args;
}

PARLOC_HD WeightArgs with_scan(WeightArgs args, const StepInput& input) {
  args.rays = with_scan(args.rays, input);
  args.models = input.models;
  args.tempering = input.tempering;
  return args;
}

/// The host's copy and the device's.
class StepInputBuffer {
 public:
  StepInputBuffer() { grow(0); }

  StepInput& host() { return *reinterpret_cast<StepInput*>(host_.data()); }
  const StepInput* device() const { return reinterpret_cast<const StepInput*>(device_.data()); }

  /// Returns whether the arrays moved.
  bool set_scan(const BeamTable& t) {
    const bool moves = t.count > capacity_;
    if (moves) grow(t.count);
    host().scan = t;
    const std::array from = {&t.origin_x, &t.origin_y,      &t.direction_x, &t.direction_y,
                             &t.range_m,  &t.short_density, &t.end_x,       &t.end_y};
    for (std::size_t k = 0; k < from.size(); ++k)
      std::copy(from[k]->begin(), from[k]->end(), array(host_.data(), k));
    return moves;
  }

  void copy_to_device(Stream stream) const { copy_down(device_.data(), host_.data(), host_.size(), stream); }

  /// Where the arrays are on the device, with the shape that the host knows.
  Beams beams() {
    const auto at = [this](std::size_t k) { return array(device_.data(), k); };
    return {host().scan, at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
  }

 private:
  static constexpr std::size_t kArrays = 8;

  float* array(unsigned char* memory, std::size_t k) const {
    return reinterpret_cast<float*>(memory + sizeof(StepInput)) + k * capacity_;
  }
  void grow(std::size_t beams) {
    const StepInput kept = host_.data() == nullptr ? StepInput{} : host();
    capacity_ = beams;
    const std::size_t bytes = sizeof(StepInput) + kArrays * capacity_ * sizeof(float);
    host_.reserve(bytes);
    device_.reserve(bytes);
    std::fill_n(host_.data(), host_.size(), static_cast<unsigned char>(0));
    host() = kept;
  }

  std::size_t capacity_ = 0;
  HostBuffer<unsigned char> host_;
  DeviceBuffer<unsigned char> device_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
