// What is learned from a simulated log is what it was simulated with.
#include <gtest/gtest.h>

#include "common/config/config.h"
#include "common/simulator/simulator.h"
#include "tests/unit/temp_file.h"
#include "tools/learn/learn.h"

namespace parloc {
namespace {

GridMap hall() {
  std::vector<std::string> rows(200, std::string(240, '.'));
  for (std::size_t i = 0; i < 240; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  return grid_from_text(rows, 0.05, {-1.0, 2.0, 0.3});
}

Scenario drive() {
  Scenario s;
  const auto point = [](double x_m, double y_m) {
    const Pose p = compose({-1.0, 2.0, 0.3}, {x_m, y_m, 0.0});
    return Waypoint{p.x_m, p.y_m, 0.0};
  };
  s.path.points = {point(2.0, 5.0), point(9.0, 4.0), point(7.0, 8.0)};
  s.lidar.beams = 180;
  s.lidar.angle_min_rad = -3.1;
  s.lidar.angle_step_rad = 0.0345;
  s.lidar.sigma_range_m = 0.05;
  return s;
}

struct Learned {
  Mixture mixture;
  double unmapped_share;
  tools::RangePairsOfLog found;
};

Learned learn(const Scenario& scenario) {
  const SimulatedLog log = simulate(scenario, hall());
  Config config;
  config.scan.max_beams = 180;
  Learned l;
  l.found = tools::collect_range_pairs(hall(), *carmen_log_from_text(carmen_text(log), "simulated.log"),
                                       log.truth, config, {});
  l.mixture = fit_mixture(l.found.ranges, {}).mixture;
  l.unmapped_share = static_cast<double>(log.unmapped) / static_cast<double>(log.beams);
  return l;
}

TEST(Learn, TheNoiseOfALogComesBack) {
  const Learned l = learn(drive());
  EXPECT_EQ(l.found.without_pose, 0u);
  EXPECT_GT(l.found.ranges.pairs.size(), 30000u);
  // The log is rounded to 0.1 mm and cast in the filter's own map: what is left is float32.
  EXPECT_NEAR(l.mixture.sigma_m, 0.05, 0.001);
  EXPECT_GT(l.mixture.z_hit, 0.97);
}

TEST(Learn, TheShareOfUnmappedThingsComesBack) {
  Scenario s = drive();
  s.clutter.people = 5;
  const Learned l = learn(s);
  ASSERT_GT(l.unmapped_share, 0.15);
  // People stand at some distances and not at others, which is not exponential: what that leaves goes to
  // rand.
  EXPECT_NEAR(l.mixture.z_short + l.mixture.z_rand, l.unmapped_share, 0.02);
  EXPECT_GT(l.mixture.z_short, 0.8 * l.unmapped_share);
  EXPECT_NEAR(l.mixture.sigma_m, 0.05, 0.003);
}

TEST(Learn, ThePictureIsWritten) {
  const Learned l = learn(drive());
  const test::TempFile file("mixture.png", "");
  tools::write_mixture_picture(file.path(), l.found.ranges, l.mixture);
  EXPECT_GT(std::filesystem::file_size(file.path()), 1000u);
}

}  // namespace
}  // namespace parloc
