// Initial particle sets, in the grid frame of a map (SPEC 6.2 and stream 1 of 0.5).
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/filter_backend.h"
#include "common/filter/pose/gaussian.h"
#include "common/filter/pose/pose_guess.h"
#include "common/map/grid_map.h"

namespace parloc {

/// Gaussian about a pose of the map frame; normals 0 to 2 of stream gaussian_start, times the root, are x, y,
/// theta, along the map's axes. `step` tells draws of one run apart.
ParticleSet gaussian_start(const GridMap& map, const Pose& pose_in_map, const CovarianceRoot& root,
                           std::int64_t particles, std::uint64_t seed, std::uint32_t step = 0);
inline ParticleSet gaussian_start(const GridMap& map, const Pose& pose_in_map, double sigma_x_m,
                                  double sigma_y_m, double sigma_theta_rad, std::int64_t particles,
                                  std::uint64_t seed) {
  return gaussian_start(map, pose_in_map, {.xx = sigma_x_m, .yy = sigma_y_m, .tt = sigma_theta_rad},
                        particles, seed);
}

/// Gaussians about several guesses, each with its share of the particles.
ParticleSet mixture_start(const GridMap& map, const std::vector<PoseGuess>& guesses, std::int64_t particles,
                          std::uint64_t seed, std::uint32_t step);

/// Row-major indices of the free cells. Throws Error{input} if there are none.
std::vector<std::uint32_t> free_cells(const GridMap& map);

/// Uniform over the free cells and all headings. Throws Error{input} for a map without free cells.
ParticleSet uniform_start(const GridMap& map, std::int64_t particles, std::uint64_t seed);

}  // namespace parloc
