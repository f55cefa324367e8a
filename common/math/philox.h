// Counter-based random numbers: Philox4x32-10 (Salmon et al. 2011; SPEC 0.5). No state and no order: a number
// is a function of who asks (slot, step, stream, block) and of the seed, hence the same on every backend.
#pragma once

#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// Who draws. Fixed numbers: they are part of every digest.
enum class Stream : std::uint32_t {
  motion = 0,
  gaussian_start = 1,
  multinomial = 2,
  systematic = 3,
  stratified = 4,
  residual = 5,
  metropolis = 6,
  rejection = 7,
  uniform_start = 8,
  injection = 9,
  simulated_odometry = 10,
  simulated_beams = 11,
  slam_proposal = 12,
  stochastic_flow = 13,
};

struct Philox4x32 {
  std::uint32_t w[4];
};

/// Ten rounds on counter (c0, c1, c2, c3) = (slot, step, stream, block) with key (seed low word, seed high
/// word).
PARLOC_HD Philox4x32 philox(std::uint32_t c0, std::uint32_t c1, std::uint32_t c2, std::uint32_t c3,
                            std::uint64_t seed) {
  std::uint32_t k0 = static_cast<std::uint32_t>(seed);
  std::uint32_t k1 = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * c0;
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * c2;
    c0 = static_cast<std::uint32_t>(p1 >> 32) ^ c1 ^ k0;
    c1 = static_cast<std::uint32_t>(p1);
    c2 = static_cast<std::uint32_t>(p0 >> 32) ^ c3 ^ k1;
    c3 = static_cast<std::uint32_t>(p0);
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return {{c0, c1, c2, c3}};
}

PARLOC_HD Philox4x32 philox(std::uint32_t slot, std::uint32_t step, Stream stream, std::uint32_t block,
                            std::uint64_t seed) {
  return philox(slot, step, static_cast<std::uint32_t>(stream), block, seed);
}

/// Uniform in (0, 1], 24 bits: never 0, so that its logarithm is finite.
PARLOC_HD float uniform_positive(std::uint32_t word) {
  return static_cast<float>(static_cast<std::int32_t>((word >> 8) + 1)) * 0x1p-24f;
}

/// Uniform in [0, 1), 24 bits.
PARLOC_HD float uniform_unit(std::uint32_t word) {
  return static_cast<float>(static_cast<std::int32_t>(word >> 8)) * 0x1p-24f;
}

/// Integer in [0, n) by multiply-high; its bias is at most n / 2^32.
PARLOC_HD std::uint32_t uniform_below(std::uint32_t word, std::uint32_t n) {
  return static_cast<std::uint32_t>((std::uint64_t{word} * n) >> 32);
}

/// The first two words as one 64-bit number (w1 high).
PARLOC_HD std::uint64_t word64(const Philox4x32& r) {
  return (std::uint64_t{r.w[1]} << 32) | r.w[0];
}

/// Four standard normals, two Box-Muller pairs (w0, w1) and (w2, w3). No rejection: counters never diverge.
struct Normals {
  float n[4];
};
PARLOC_HD Normals normals(const Philox4x32& r) {
  Normals out;
  for (int pair = 0; pair < 2; ++pair) {
    const float radius = portable_sqrt(-2.0f * portable_log(uniform_positive(r.w[2 * pair])));
    const SinCos a = portable_sincos(6.28318548f * uniform_unit(r.w[2 * pair + 1]));
    out.n[2 * pair] = radius * a.cos;
    out.n[2 * pair + 1] = radius * a.sin;
  }
  return out;
}

}  // namespace parloc
