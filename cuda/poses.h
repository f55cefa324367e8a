// Poses of particles, structure of arrays: a backend keeps two and goes back and forth between them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/memory.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Room for so many particles; `live` says how many of them are there.
struct Poses {
  DeviceBuffer<float> x, y, theta;
  DeviceBuffer<std::uint32_t> live;
  explicit Poses(std::size_t n) {
    for (auto* b : {&x, &y, &theta}) b->reserve(n);
    live.reserve(1);
  }
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
