// The map that a flow linearised at the mean applies to every particle. All its steps are affine and the same
// for all particles, so they are put together first, and particles are touched once per scan.
#pragma once

#include <cstdint>

#include "common/flow/exact_flow.h"
#include "common/math/philox.h"
#include "common/math/portable.h"

namespace parloc {

/// e <- a e + b + sum over the steps of noise[j] xi_j, about a centre; float64 while it is put together.
struct CloudMap {
  Matrix3 a;
  Vector3 b;
  Vector3 noise[kMostFlowSteps];
  int noisy_steps = 0;

  PARLOC_HD void clear() {
    a = identity3();
    b = Vector3{};
    noisy_steps = 0;
  }
  PARLOC_HD void append(const FlowStep& f, const Vector3& k, const Vector3& h) {
    for (int j = 0; j < 3; ++j) {
      Vector3 column;
      for (int i = 0; i < 3; ++i) column[i] = a(i, j);
      const double along = f.pull * dot(h, column);
      for (int i = 0; i < 3; ++i) a(i, j) -= k[i] * along;
    }
    b = flowed(b, f, k, h);
    if (f.noise == 0.0) return;
    for (int j = 0; j < noisy_steps; ++j) noise[j] = plus(noise[j], -f.pull * dot(h, noise[j]), k);
    noise[noisy_steps] = Vector3{};
    noise[noisy_steps] = plus(noise[noisy_steps], f.noise, k);
    ++noisy_steps;
  }
};

/// The same in float32, as particles take it.
struct CloudMove {
  float centre[3] = {};
  float a[9] = {};
  float b[3] = {};
  float noise[kMostFlowSteps][3] = {};
  std::int32_t noisy_steps = 0;
};

/// About the float32 number nearest to `centre`; what lies between them goes into b.
PARLOC_HD void finish_cloud_move(const CloudMap& map, const Vector3& centre, CloudMove& move) {
  Vector3 off;
  for (int i = 0; i < 3; ++i) {
    move.centre[i] = static_cast<float>(centre[i]);
    off[i] = static_cast<double>(move.centre[i]) - centre[i];
  }
  const Vector3 b = plus(plus(map.b, 1.0, multiply(map.a, off)), -1.0, off);
  for (int i = 0; i < 9; ++i) move.a[i] = static_cast<float>(map.a.m[i]);
  for (int i = 0; i < 3; ++i) move.b[i] = static_cast<float>(b[i]);
  for (int j = 0; j < map.noisy_steps; ++j)
    for (int i = 0; i < 3; ++i) move.noise[j][i] = static_cast<float>(map.noise[j][i]);
  move.noisy_steps = map.noisy_steps;
}

/// Moves one particle. Noise: stream stochastic_flow, four steps' numbers per block.
PARLOC_HD void move_one(float& x, float& y, float& theta, const CloudMove& m, std::uint32_t slot,
                        std::uint32_t step, std::uint64_t seed) {
  const float e0 = x - m.centre[0], e1 = y - m.centre[1], e2 = wrap(theta - m.centre[2]);
  float d[3];
  for (int i = 0; i < 3; ++i)
    d[i] = fused(m.a[3 * i], e0, fused(m.a[3 * i + 1], e1, fused(m.a[3 * i + 2], e2, m.b[i])));
  for (std::int32_t j = 0; j < m.noisy_steps; j += 4) {
    const Normals n =
        normals(philox(slot, step, Stream::stochastic_flow, static_cast<std::uint32_t>(j) / 4, seed));
    for (std::int32_t l = 0; l < 4 && j + l < m.noisy_steps; ++l)
      for (int i = 0; i < 3; ++i) d[i] = fused(m.noise[j + l][i], n.n[l], d[i]);
  }
  x = m.centre[0] + d[0];
  y = m.centre[1] + d[1];
  theta = wrap(m.centre[2] + d[2]);
}

}  // namespace parloc
