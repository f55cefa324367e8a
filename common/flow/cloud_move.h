// The map that a flow linearised at the mean applies to every particle. All its steps are affine and the same
// for all particles, so they are put together first, and particles are touched once per scan.
#pragma once

#include <cstdint>

#include "common/flow/exact_flow.h"
#include "common/math/philox.h"
#include "common/math/portable.h"

namespace parloc {

/// e <- a e + b + noise, about a centre; float64 while it is put together. A step's noise is the same vector
/// for all particles times a number of their own, so the noise of all steps is one Gaussian.
struct CloudMap {
  Matrix3 a;
  Vector3 b;
  Matrix3 noise;  ///< Covariance.
  bool noisy = false;

  PARLOC_HD void clear() {
    a = identity3();
    b = Vector3{};
    noise = Matrix3{};
    noisy = false;
  }
  PARLOC_HD void append(const FlowStep& f, const Vector3& k, const Vector3& h) {
    Matrix3 step = identity3();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) step(i, j) -= f.pull * k[i] * h[j];
    a = multiply(step, a);
    b = flowed(b, f, k, h);
    if (f.noise == 0.0) return;
    noisy = true;
    noise = plus_outer(sandwich(step, noise), f.noise * f.noise, k);
  }
};

/// The same in float32, as particles take it.
struct CloudMove {
  float centre[3] = {};
  float a[9] = {};
  float b[3] = {};
  float noise[9] = {};  ///< Lower triangle: times standard normals.
  bool noisy = false;
};

/// `centre`: float32 numbers, so that particles are seen from the very point that the map is about.
PARLOC_HD void finish_cloud_move(const CloudMap& map, const Vector3& centre, CloudMove& move) {
  const Matrix3 root = semidefinite_root(map.noise);
  for (int i = 0; i < 9; ++i) {
    move.a[i] = static_cast<float>(map.a.m[i]);
    move.noise[i] = static_cast<float>(root.m[i]);
  }
  for (int i = 0; i < 3; ++i) {
    move.centre[i] = static_cast<float>(centre[i]);
    move.b[i] = static_cast<float>(map.b[i]);
  }
  move.noisy = map.noisy;
}

/// Moves one particle. `noisy`: as move says, from outside so that a loop need not ask.
PARLOC_HD void move_one(float& x, float& y, float& theta, const CloudMove& m, bool noisy, std::uint32_t slot,
                        std::uint32_t step, std::uint64_t seed) {
  const float e0 = x - m.centre[0], e1 = y - m.centre[1], e2 = wrap(theta - m.centre[2]);
  float d[3];
  for (int i = 0; i < 3; ++i)
    d[i] = fused(m.a[3 * i], e0, fused(m.a[3 * i + 1], e1, fused(m.a[3 * i + 2], e2, m.b[i])));
  if (noisy) {
    const Normals n = normals(philox(slot, step, Stream::stochastic_flow, 0, seed));
    d[0] = fused(m.noise[0], n.n[0], d[0]);
    d[1] = fused(m.noise[3], n.n[0], fused(m.noise[4], n.n[1], d[1]));
    d[2] = fused(m.noise[6], n.n[0], fused(m.noise[7], n.n[1], fused(m.noise[8], n.n[2], d[2])));
  }
  x = m.centre[0] + d[0];
  y = m.centre[1] + d[1];
  theta = wrap(m.centre[2] + d[2]);
}

}  // namespace parloc
