#include "common/filter/start.h"

#include "common/error.h"
#include "common/filter/bind.h"
#include "common/filter/free_space.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

ParticleSet empty_set(std::int64_t particles) {
  const auto n = static_cast<std::size_t>(particles);
  return {std::vector<float>(n), std::vector<float>(n), std::vector<float>(n), std::vector<float>(n, 0.0f)};
}

/// Particle i: normals 0 to 2, times the root, are x, y, theta.
void draw_about(const GridMap& map, const Pose& pose, const CovarianceRoot& root, std::uint32_t step,
                std::uint64_t seed, ParticleSet& set, std::size_t i) {
  const Normals n = normals(philox(static_cast<std::uint32_t>(i), step, Stream::gaussian_start, 0, seed));
  const double x = n.n[0], y = n.n[1], theta = n.n[2];
  const Pose drawn{pose.x_m + root.xx * x, pose.y_m + (root.yx * x + root.yy * y),
                   wrap64(pose.theta_rad + (root.tx * x + root.ty * y + root.tt * theta))};
  const Pose in_grid = relative(drawn, map.T_map_grid);
  set.x[i] = static_cast<float>(in_grid.x_m);
  set.y[i] = static_cast<float>(in_grid.y_m);
  set.theta[i] = wrap(static_cast<float>(in_grid.theta_rad));
}

}  // namespace

ParticleSet gaussian_start(const GridMap& map, const Pose& pose, const CovarianceRoot& root,
                           std::int64_t particles, std::uint64_t seed, std::uint32_t step) {
  ParticleSet set = empty_set(particles);
  for (std::size_t i = 0; i < set.x.size(); ++i) draw_about(map, pose, root, step, seed, set, i);
  return set;
}

ParticleSet mixture_start(const GridMap& map, const std::vector<PoseGuess>& guesses, std::int64_t particles,
                          std::uint64_t seed, std::uint32_t step) {
  double total = 0.0;
  for (const PoseGuess& g : guesses) total += g.weight;
  ParticleSet set = empty_set(particles);
  std::size_t guess = 0;
  double up_to = guesses[0].weight;  // of the guesses so far
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(set.x.size()) * total;
    while (at > up_to && guess + 1 < guesses.size()) up_to += guesses[++guess].weight;
    const PoseGuess& g = guesses[guess];
    const CovarianceRoot root{.xx = g.sigma_xy_m, .yy = g.sigma_xy_m, .tt = g.sigma_theta_rad};
    draw_about(map, g.pose, root, step, seed, set, i);
  }
  return set;
}

std::vector<std::uint32_t> free_cells(const GridMap& map) {
  std::vector<std::uint32_t> cells;
  for (std::size_t c = 0; c < map.size(); ++c)
    if (map.cells[c] == Cell::free) cells.push_back(static_cast<std::uint32_t>(c));
  if (cells.empty()) throw Error(ErrorKind::input, map.name + ": the map has no free cell");
  return cells;
}

ParticleSet uniform_start(const GridMap& map, std::int64_t particles, std::uint64_t seed) {
  const std::vector<std::uint32_t> cells = free_cells(map);
  const FreeSpace free = bind_free_space(cells.data(), cells.size(), map);
  ParticleSet set = empty_set(particles);
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const GridPose pose =
        free_pose(free, philox(static_cast<std::uint32_t>(i), 0, Stream::uniform_start, 0, seed));
    set.x[i] = pose.x;
    set.y[i] = pose.y;
    set.theta[i] = pose.theta;
  }
  return set;
}

}  // namespace parloc
