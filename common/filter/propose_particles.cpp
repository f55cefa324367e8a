#include "common/filter/propose_particles.h"

#include <cmath>

#include "common/math/philox.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// Block of stream gaussian_start: 0 is that of starts.
constexpr std::uint32_t kBlock = 1;

/// Logarithm of a Gaussian's density at this distance and turn from its mean, but for a constant.
double log_density(double distance_m, double turn_rad, double sigma_m, double sigma_rad) {
  const double along = distance_m / sigma_m, about = turn_rad / sigma_rad;
  return -0.5 * (along * along + about * about) - 2.0 * portable_log64(sigma_m) - portable_log64(sigma_rad);
}

}  // namespace

void propose_particles(ParticleSet& set, const GridMap& map, const PoseGuess& guess, double share,
                       const SlipPrior& slip, std::uint32_t step, std::uint64_t seed) {
  const std::size_t count = set.x.size();
  double total = 0.0;
  for (const float log_weight : set.log_weight) total += portable_exp64(static_cast<double>(log_weight));
  const double mean = portable_log64(total / static_cast<double>(count));
  const double base = mean + portable_log64(slip.odds) - portable_log64(share / (1.0 - share));
  const auto due = [&](std::size_t i) { return std::floor(static_cast<double>(i) * share); };
  for (std::size_t i = 0; i < count; ++i) {
    if (due(i + 1) == due(i)) continue;
    const Normals n =
        normals(philox(static_cast<std::uint32_t>(i), step, Stream::gaussian_start, kBlock, seed));
    const Pose drawn{guess.pose.x_m + guess.sigma_xy_m * n.n[0], guess.pose.y_m + guess.sigma_xy_m * n.n[1],
                     wrap64(guess.pose.theta_rad + guess.sigma_theta_rad * n.n[2])};
    const Pose in_grid = relative(drawn, map.T_map_grid);
    set.x[i] = static_cast<float>(in_grid.x_m);
    set.y[i] = static_cast<float>(in_grid.y_m);
    set.theta[i] = wrap(static_cast<float>(in_grid.theta_rad));
    set.log_weight[i] =
        static_cast<float>(base +
                           log_density(distance_m(drawn, slip.expected), turn_rad(drawn, slip.expected),
                                       slip.sigma_m, slip.sigma_rad) -
                           log_density(distance_m(drawn, guess.pose), turn_rad(drawn, guess.pose),
                                       guess.sigma_xy_m, guess.sigma_theta_rad));
  }
}

}  // namespace parloc
