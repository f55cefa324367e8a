// Particles that are put where a scan says keep the set an honest sample of where the motion says.
#include "common/filter/propose_particles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/filter/start.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

constexpr std::int64_t kParticles = 20000;
const Pose kHere{4.0, 3.0, 0.4};

struct Weights {
  double proposed = 0.0, kept = 0.0;
  std::size_t count = 0;
};
/// By whether a particle is one of those that were drawn about `guess`.
Weights weigh(const ParticleSet& before, const ParticleSet& after) {
  Weights w;
  for (std::size_t i = 0; i < after.x.size(); ++i) {
    const bool kept = after.x[i] == before.x[i] && after.theta[i] == before.theta[i];
    (kept ? w.kept : w.proposed) += std::exp(static_cast<double>(after.log_weight[i]));
    w.count += kept ? 0 : 1;
  }
  return w;
}

GridMap floor_of_cells() {
  return grid_from_text(std::vector<std::string>(80, std::string(120, '.')), 0.1);
}

// A guess as wide as the slips themselves samples the whole of them: the weights then sum to the odds.
TEST(ProposeParticles, WeightsAreThoseOfTheSlip) {
  const GridMap map = floor_of_cells();
  for (const double share : {0.1, 0.25, 0.5})
    for (const double odds : {0.01, 0.1}) {
      const ParticleSet before = gaussian_start(map, kHere, 0.05, 0.05, 0.02, kParticles, 1);
      ParticleSet after = before;
      const SlipPrior slip{kHere, 0.3, 0.2, odds};
      propose_particles(after, map, {kHere, 0.45, 0.3}, share, slip, 3, 7);
      const Weights w = weigh(before, after);
      EXPECT_NEAR(static_cast<double>(w.count), share * kParticles, 1.0);
      // 2000 draws or more whose weights vary by a factor of two: 5 standard errors are 0.1.
      EXPECT_NEAR(w.proposed / w.kept / odds, 1.0, 0.1) << share << " " << odds;
    }
}

// The farther a place is from where the wheels say that it is, the less it weighs: as the slip's density.
TEST(ProposeParticles, ADistantPlaceWeighsAsTheSlipsDensityThere) {
  const GridMap map = floor_of_cells();
  const ParticleSet before = gaussian_start(map, kHere, 0.05, 0.05, 0.02, kParticles, 1);
  const SlipPrior slip{kHere, 0.3, 0.2, 0.05};
  const auto proposed = [&](double far_m) {
    ParticleSet after = before;
    const Pose there{kHere.x_m + far_m, kHere.y_m, kHere.theta_rad};
    propose_particles(after, map, {there, 0.02, 0.01}, 0.25, slip, 3, 7);
    return weigh(before, after).proposed;
  };
  // Narrow guesses are seen by their own width: the ratio is that of the densities at their middles, but for
  // the slip's slope over 2 cm.
  EXPECT_NEAR(std::log(proposed(0.3) / proposed(0.0)), -0.5, 0.05);
  EXPECT_NEAR(std::log(proposed(0.6) / proposed(0.0)), -2.0, 0.1);
}

TEST(ProposeParticles, CarriedWeightsAreKeptInProportion) {
  const GridMap map = floor_of_cells();
  ParticleSet before = gaussian_start(map, kHere, 0.05, 0.05, 0.02, kParticles, 1);
  for (float& w : before.log_weight) w = -30.0f;  // far below 0: only their ratio counts
  ParticleSet after = before;
  propose_particles(after, map, {kHere, 0.45, 0.3}, 0.25, {kHere, 0.3, 0.2, 0.1}, 3, 7);
  const Weights w = weigh(before, after);
  EXPECT_NEAR(w.proposed / w.kept, 0.1, 0.01);
}

}  // namespace
}  // namespace parloc
