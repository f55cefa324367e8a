// What the scenes of segments show (maps/square_ring.yaml, maps/round_ring.yaml): in a corridor without
// features nothing tells how far along one is, and the filter's covariance says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/config/config.h"
#include "common/filter/particle_filter.h"
#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

const std::string kRoot = std::string(PARLOC_SOURCE_DIR) + "/";

struct Step {
  Pose truth, estimate;
  double sigma_along_m, sigma_across_m, sigma_heading_rad;  // along and across the true heading
};

std::vector<Step> drive(const std::string& scene, std::uint64_t seed) {
  Scenario scenario = read_scenario(kRoot + "configs/" + scene + "_scenario.yaml");
  scenario.seed = seed;
  const GridMap map = read_map(scenario.map_path);
  const SimulatedLog log = simulate(scenario, map, [](double) { return true; });
  Config config = read_config(kRoot + "configs/segments.yaml");
  config.seed = seed;
  ParticleFilter filter(config, map);
  filter.start_at(log.truth.front().pose, 0.05, 0.05, 0.02);
  std::vector<Step> steps;
  for (const LogRecord& record : log.records) {
    if (record.kind != RecordKind::scan) continue;
    const Pose truth = log.truth[steps.size()].pose;
    const Estimate e = filter.step(record.odometry, record.scan);
    const double c = std::cos(truth.theta_rad), s = std::sin(truth.theta_rad);
    const auto& v = e.covariance.v;
    steps.push_back({truth, e.pose, std::sqrt(c * c * v[0] + 2 * c * s * v[1] + s * s * v[4]),
                     std::sqrt(s * s * v[0] - 2 * c * s * v[1] + c * c * v[4]), std::sqrt(v[8])});
  }
  return steps;
}

double most(const std::vector<Step>& steps, double Step::*what) {
  double most = 0.0;
  for (const Step& s : steps) most = std::max(most, s.*what);
  return most;
}

/// The steps of the first leg, along +x, between two places.
std::vector<Step> between(const std::vector<Step>& steps, double from_x_m, double to_x_m) {
  std::vector<Step> some;
  for (const Step& s : steps) {
    if (s.truth.x_m > to_x_m) break;
    if (s.truth.x_m >= from_x_m) some.push_back(s);
  }
  return some;
}

// The start is known to 0.05 m; the odometry's noise adds 0.03 m per scan, 0.4 m in 18 m. 512 particles that
// are resampled all the time hold less of it (their common ancestor is not far back), so this asks for half.
TEST(SquareRing, ItIsUnknownHowFarAlongOneIsUntilACornerIsInSight) {
  for (const std::uint64_t seed : {1, 2}) {
    SCOPED_TRACE(seed);
    const std::vector<Step> steps = drive("square_ring", seed);
    // The end wall at 45 m is 20 m away, the range of the LiDAR, at 25 m.
    const std::vector<Step> blind = between(steps, 6.0, 24.9), seeing = between(steps, 25.5, 30.0);
    const double peak_m = most(blind, &Step::sigma_along_m);
    std::printf("seed %d: along up to %.3f m, then %.3f m; across up to %.3f m\n", static_cast<int>(seed),
                peak_m, most(seeing, &Step::sigma_along_m), most(blind, &Step::sigma_across_m));
    EXPECT_GT(peak_m, 4 * 0.05);
    EXPECT_LT(most(blind, &Step::sigma_across_m), 0.1 * peak_m);
    EXPECT_LT(most(seeing, &Step::sigma_along_m), 0.5 * peak_m) << "5 scans after the corner came in sight";
  }
}

TEST(RoundRing, WhereAlongItOneIsCannotBeSeen) {
  constexpr double kRadius_m = 20.0, kCentre_m = 22.5;
  for (const std::uint64_t seed : {1, 2}) {
    SCOPED_TRACE(seed);
    const std::vector<Step> steps = drive("round_ring", seed);
    const auto radius_m = [](const Pose& p) { return std::hypot(p.x_m - kCentre_m, p.y_m - kCentre_m); };
    double along_m = 0.0, across_m = 0.0, turned = 0.0;
    for (const Step& s : steps) {
      EXPECT_NEAR(radius_m(s.estimate), radius_m(s.truth), 0.1);
      along_m += s.sigma_along_m / static_cast<double>(steps.size());
      across_m += s.sigma_across_m / static_cast<double>(steps.size());
      turned += s.sigma_heading_rad * kRadius_m / static_cast<double>(steps.size());
    }
    std::printf("seed %d: along %.3f m, across %.3f m, heading times radius %.3f m on average\n",
                static_cast<int>(seed), along_m, across_m, turned);
    EXPECT_GT(along_m, 4 * 0.05);
    EXPECT_LT(across_m, 0.1 * along_m);
    EXPECT_NEAR(turned, along_m, 0.2 * along_m) << "who is farther along is turned as much";
  }
}

}  // namespace
}  // namespace parloc
