#include "cpu/space.h"

#include <fmt/format.h>
#include <hwy/targets.h>
#include <omp.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "common/file/processor_name.h"
#include "common/filter/filter_backend.h"

namespace parloc {
namespace cpu {
namespace {

Simd best_of_this_cpu() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 =
      __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512cd");
  if (avx512) return Simd::avx512;
  if (avx2) return Simd::avx2;
#endif
  return Simd::baseline;
}

Simd first_level() {
  const Simd best = best_of_this_cpu();
  const char* wish = std::getenv("PARLOC_SIMD");
  if (wish == nullptr) return best;
  if (std::strcmp(wish, "baseline") == 0) return Simd::baseline;
  if (std::strcmp(wish, "avx2") == 0) return std::min(best, Simd::avx2);
  return best;
}

/// Highway chooses for cpu/ray_trace.cpp by itself: it gets the same limit. Its better targets have lower
/// bits.
Simd limit_highway(Simd most) {
#if defined(__x86_64__)
  hwy::DisableTargets(most == Simd::avx512 ? 0 : HWY_AVX2 - 1);
#endif
  return most;
}

Simd& level() {
  static Simd current = limit_highway(first_level());
  return current;
}

}  // namespace

Simd simd_level() {
  return level();
}
void limit_simd(Simd most) {
  level() = limit_highway(std::min(most, best_of_this_cpu()));
}

const char* simd_name(Simd l) {
  switch (l) {
    case Simd::avx512:
      return "AVX-512";
    case Simd::avx2:
      return "AVX2";
    case Simd::baseline:
      break;
  }
  return "baseline";
}

Workers Workers::open(int threads, int) {
  Workers workers;
  workers.threads = threads > 0 ? threads : omp_get_num_procs();
  return workers;
}

std::string Workers::name() const {
  return fmt::format("cpu ({}, {} thread{})", simd_name(simd_level()), threads, threads == 1 ? "" : "s");
}

}  // namespace cpu

std::string describe_cpu() {
  return fmt::format("cpu: {}, {} cores, using {}", processor_name(), omp_get_num_procs(),
                     cpu::simd_name(cpu::simd_level()));
}

}  // namespace parloc
