// Integers for every sum whose order a thread schedule could change (DESIGN: same seed, same answer).
#pragma once

#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// Per-beam log-likelihoods of rays are rounded to 2^-16 nat and added as 64-bit integers: any order gives
/// the same sum. (Those of the likelihood field are integers in a unit of its own.)
constexpr float kLogLikelihoodScale = 65536.0f;
constexpr float kLogLikelihoodUnit_nat = 1.0f / kLogLikelihoodScale;
constexpr float kLogLikelihoodFloor = -30000.0f;  // keeps one beam inside 32 bits

PARLOC_HD std::int32_t fixed_log_likelihood(float log_likelihood) {
  return nearest_of(max_of(log_likelihood, kLogLikelihoodFloor) * kLogLikelihoodScale);
}

/// log-weight after a scan: previous + tempering * sum of the beams.
PARLOC_HD float tempered_log_weight(float previous, std::int64_t beam_sum, float unit_nat, float tempering) {
  return fused(static_cast<float>(beam_sum), tempering * unit_nat, previous);
}

/// Of a number that is not 0.
PARLOC_HD int leading_zeros(std::uint64_t x) {
#if defined(__CUDA_ARCH__)
  return __clzll(static_cast<long long>(x));
#else
  return __builtin_clzll(x);
#endif
}

/// Bits of a fixed-point weight: S = min(40, 62 - ceil(log2 N)), so that N weights never overflow (SPEC 5.4).
PARLOC_HD int weight_bits(std::uint64_t particles) {
  const int log2_ceil = particles > 1 ? 64 - leading_zeros(particles - 1) : 0;
  const int bits = 62 - log2_ceil;
  return bits < 40 ? bits : 40;
}

/// exp(log_weight - max) as an integer of `bits` bits; 0 below 2^-(bits+1).
PARLOC_HD std::uint64_t fixed_weight(float log_weight, float max_log_weight, int bits) {
  const float w = portable_exp(log_weight - max_log_weight);
  // The float has 24 significant bits: scaling by a power of two is exact, and so is the conversion after
  // rint.
  const float scaled = w * float_of(static_cast<std::uint32_t>(bits + 127) << 23);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(round_even(scaled)));
}

/// High 64 bits of a 64 x 64-bit product.
PARLOC_HD std::uint64_t multiply_high(std::uint64_t a, std::uint64_t b) {
#if defined(__CUDA_ARCH__)
  return __umul64hi(a, b);
#else
  return static_cast<std::uint64_t>((static_cast<unsigned __int128>(a) * b) >> 64);
#endif
}

}  // namespace parloc
