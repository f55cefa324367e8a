// Poses of particles, structure of arrays: a backend keeps two and goes back and forth between them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace parloc::cpu {

/// Room for so many particles; `count` of them are there.
struct Poses {
  std::vector<float> x, y, theta;
  std::uint32_t count;
  explicit Poses(std::size_t n) : x(n), y(n), theta(n), count(static_cast<std::uint32_t>(n)) {}
};

}  // namespace parloc::cpu
