// One binary, the best instruction set at run time: a loop written once is compiled for several sets.
// The arithmetic is the same on all of them (no contraction, explicit fma), hence so are the bits.
#pragma once

namespace parloc::cpu {

/// NEON is in every 64-bit ARM CPU, and the compiler uses it always: without it stands for rays one by one.
enum class Simd { baseline, neon, avx2, avx512 };

/// The best set that this CPU has, or the lower one named by the environment variable PARLOC_SIMD
/// (baseline, neon, avx2, avx512). Read once.
Simd simd_level();
/// For tests: use at most this set from now on. Not thread-safe.
void limit_simd(Simd most);
const char* simd_name(Simd level);

#if defined(__x86_64__)
#define PARLOC_TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,lzcnt,popcnt,f16c"), noinline))
#if defined(__clang__)
#define PARLOC_TARGET_AVX512                                                                                \
  __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512cd,avx2,fma,bmi,bmi2,lzcnt,popcnt,f16c"), \
                 noinline))
#else
#define PARLOC_TARGET_AVX512                                                                               \
  __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512cd,avx2,fma,bmi,bmi2,lzcnt,popcnt,f16c," \
                        "prefer-vector-width=512"),                                                        \
                 noinline))
#endif

template <class Loop>
PARLOC_TARGET_AVX2 void run_avx2(const Loop& loop) {
  loop();
}
template <class Loop>
PARLOC_TARGET_AVX512 void run_avx512(const Loop& loop) {
  loop();
}
#endif

/// Runs `loop`, a lambda marked PARLOC_SIMD_LOOP, compiled for the instruction set in use.
template <class Loop>
inline void run_simd(const Loop& loop) {
#if defined(__x86_64__)
  switch (simd_level()) {
    case Simd::avx512:
      run_avx512(loop);
      return;
    case Simd::avx2:
      run_avx2(loop);
      return;
    case Simd::neon:
    case Simd::baseline:
      break;
  }
#endif
  loop();
}

}  // namespace parloc::cpu

/// Marks a lambda whose body is to be compiled anew for each instruction set that runs it.
#define PARLOC_SIMD_LOOP __attribute__((always_inline))
