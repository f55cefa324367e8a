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
  simulated_clutter = 14,
  kld = 15,
  random_drive = 16,
  // Of the families of drives that the localizer is judged on.
  changed_world = 32,
  corrupted_odometry = 33,
  drawn_drive = 34,
};

struct Philox4x32 {
  std::uint32_t w[4];
};

PARLOC_HD void philox_round(std::uint32_t (&c)[4], std::uint32_t k0, std::uint32_t k1) {
  const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * c[0];
  const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * c[2];
  c[0] = static_cast<std::uint32_t>(p1 >> 32) ^ c[1] ^ k0;
  c[1] = static_cast<std::uint32_t>(p1);
  c[2] = static_cast<std::uint32_t>(p0 >> 32) ^ c[3] ^ k1;
  c[3] = static_cast<std::uint32_t>(p0);
}

/// Ten rounds on counter (c0, c1, c2, c3) = (slot, step, stream, block) with key (seed low word, seed high
/// word).
PARLOC_HD Philox4x32 philox(std::uint32_t c0, std::uint32_t c1, std::uint32_t c2, std::uint32_t c3,
                            std::uint64_t seed) {
  constexpr std::uint32_t kStep0 = 0x9E3779B9u, kStep1 = 0xBB67AE85u;
  const std::uint32_t k0 = static_cast<std::uint32_t>(seed);
  const std::uint32_t k1 = static_cast<std::uint32_t>(seed >> 32);
  std::uint32_t c[4] = {c0, c1, c2, c3};
  philox_round(c, k0, k1);  // written out: a loop in here would keep the caller's from being vectorised
  philox_round(c, k0 + kStep0, k1 + kStep1);
  philox_round(c, k0 + 2 * kStep0, k1 + 2 * kStep1);
  philox_round(c, k0 + 3 * kStep0, k1 + 3 * kStep1);
  philox_round(c, k0 + 4 * kStep0, k1 + 4 * kStep1);
  philox_round(c, k0 + 5 * kStep0, k1 + 5 * kStep1);
  philox_round(c, k0 + 6 * kStep0, k1 + 6 * kStep1);
  philox_round(c, k0 + 7 * kStep0, k1 + 7 * kStep1);
  philox_round(c, k0 + 8 * kStep0, k1 + 8 * kStep1);
  philox_round(c, k0 + 9 * kStep0, k1 + 9 * kStep1);
  return {{c[0], c[1], c[2], c[3]}};
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
PARLOC_HD void box_muller(std::uint32_t radius_word, std::uint32_t angle_word, float& first, float& second) {
  const float radius = portable_sqrt(-2.0f * portable_log(uniform_positive(radius_word)));
  const SinCos a = portable_sincos(6.28318548f * uniform_unit(angle_word));
  first = radius * a.cos;
  second = radius * a.sin;
}
PARLOC_HD Normals normals(const Philox4x32& r) {
  Normals out;
  box_muller(r.w[0], r.w[1], out.n[0], out.n[1]);
  box_muller(r.w[2], r.w[3], out.n[2], out.n[3]);
  return out;
}

}  // namespace parloc
