// For tests that run the same on several instruction sets.
#pragma once

#include <vector>

#include "cpu/simd.h"

namespace parloc::test {

/// Limits the instruction set while it lives.
class SimdLimit {
 public:
  explicit SimdLimit(cpu::Simd most) { cpu::limit_simd(most); }
  ~SimdLimit() { cpu::limit_simd(cpu::Simd::avx512); }
  SimdLimit(const SimdLimit&) = delete;
  SimdLimit& operator=(const SimdLimit&) = delete;
};

/// The instruction sets that this CPU has, each once.
inline std::vector<cpu::Simd> instruction_sets() {
  std::vector<cpu::Simd> sets;
  for (const cpu::Simd wish : {cpu::Simd::baseline, cpu::Simd::neon, cpu::Simd::avx2, cpu::Simd::avx512}) {
    const SimdLimit limit(wish);
    if (cpu::simd_level() == wish) sets.push_back(wish);
  }
  return sets;
}

}  // namespace parloc::test
