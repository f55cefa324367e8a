#include "cpu/space.h"

#include <fmt/format.h>
#include <hwy/targets.h>
#include <omp.h>

#include <cstdlib>
#include <string_view>

#include "common/file/processor_name.h"
#include "common/filter/filter_backend.h"

namespace parloc {
namespace cpu {
namespace {

/// The best set that this CPU has, of those up to `most`.
Simd best_up_to([[maybe_unused]] Simd most) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 =
      __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512cd");
  if (avx512 && most >= Simd::avx512) return Simd::avx512;
  if (avx2 && most >= Simd::avx2) return Simd::avx2;
#elif defined(__aarch64__)
  if (most >= Simd::neon) return Simd::neon;
#endif
  return Simd::baseline;
}

Simd first_level() {
  const char* wish = std::getenv("PARLOC_SIMD");
  const std::string_view most = wish == nullptr ? "" : wish;
  if (most == "baseline") return Simd::baseline;
  if (most == "neon") return best_up_to(Simd::neon);
  if (most == "avx2") return best_up_to(Simd::avx2);
  return best_up_to(Simd::avx512);
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
  level() = limit_highway(best_up_to(most));
}

const char* simd_name(Simd l) {
  switch (l) {
    case Simd::avx512:
      return "AVX-512";
    case Simd::avx2:
      return "AVX2";
    case Simd::neon:
      return "NEON";
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
