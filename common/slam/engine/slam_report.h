// What the host is to know of a scan, in one piece of memory, so that one copy brings it.
#pragma once

#include <cstddef>

#include "common/slam/slam_stages.h"

namespace parloc {

struct SlamReportHead {
  SlamTally tally;
  std::uint64_t tiles;  ///< In use now.
  StepState state;
};

/// Where it is; arrays by slot.
struct SlamReport {
  SlamReportHead* head = nullptr;
  float *x = nullptr, *y = nullptr, *theta = nullptr, *likelihood = nullptr;  ///< [N]
  std::uint32_t* ancestor = nullptr;                                          ///< [N]
};

PARLOC_HD void report_one(const SlamArgs& a, const SlamReport& to, std::size_t i) {
  to.x[i] = a.particles.x[i], to.y[i] = a.particles.y[i], to.theta[i] = a.particles.theta[i];
  to.likelihood[i] = a.likelihood[i];
  to.ancestor[i] = a.ancestor[i];
}

template <class Space>
class SlamReportBuffer {
 public:
  explicit SlamReportBuffer(std::size_t particles) : particles_(particles) {
    memory_.reserve(sizeof(SlamReportHead) + 5 * particles * sizeof(float));
  }
  SlamReport there() { return at(memory_.there()); }
  SlamReport host() { return at(memory_.host()); }
  void fetch(typename Space::Queue& queue) { memory_.fetch(queue); }

 private:
  SlamReport at(unsigned char* memory) const {
    float* const array = reinterpret_cast<float*>(memory + sizeof(SlamReportHead));
    const std::size_t n = particles_;
    return {reinterpret_cast<SlamReportHead*>(memory),      array, array + n, array + 2 * n, array + 3 * n,
            reinterpret_cast<std::uint32_t*>(array + 4 * n)};
  }

  std::size_t particles_;
  typename Space::template Mirror<unsigned char> memory_;
};

}  // namespace parloc
