// Beams of several scans, brought to the device in one copy.
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "common/filter/stages.h"
#include "common/model/beams.h"
#include "cuda/memory.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

class DeviceScans {
 public:
  /// The beams of each scan, hits and misses, where they are on the device until the next call. What is named
  /// twice is copied once.
  std::vector<Beams> upload(const std::vector<const BeamTable*>& scans, Stream stream) {
    std::unordered_map<const BeamTable*, std::size_t> at;
    std::vector<float> values;
    for (const BeamTable* t : scans) {
      if (!at.emplace(t, values.size()).second) continue;
      for (const auto* a :
           {&t->origin_x, &t->origin_y, &t->direction_x, &t->direction_y, &t->range_m, &t->end_x, &t->end_y})
        for (std::size_t m = 0; m < t->count; ++m) values.push_back(m < a->size() ? (*a)[m] : 0.0f);
    }
    values_.from_host(values, stream);
    std::vector<Beams> beams;
    for (const BeamTable* t : scans) {
      const auto array = [&](std::size_t k) { return values_.data() + at[t] + k * t->count; };
      beams.push_back({*t, array(0), array(1), array(2), array(3), array(4), nullptr, array(5), array(6)});
    }
    return beams;
  }

 private:
  DeviceBuffer<float> values_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
