// Adaptive Monte Carlo localization as a user meets it: a global start that shrinks, a kidnapped robot that
// is found again, a cloud that is widened.
#include <gtest/gtest.h>

#include "common/filter/particle_filter.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

/// 12 x 8 m in cells of 5 cm: three rooms, no two alike, and a corridor.
GridMap flat() {
  std::vector<std::string> rows(160, "#" + std::string(238, '.') + "#");
  rows.front() = rows.back() = std::string(240, '#');
  const auto wall = [&](std::size_t j, std::size_t i, std::size_t high, std::size_t wide) {
    for (std::size_t k = j; k < j + high; ++k) rows[k].replace(i, wide, std::string(wide, '#'));
  };
  wall(60, 0, 2, 30), wall(60, 50, 2, 60), wall(60, 130, 2, 110);  // rooms above, corridor below
  wall(0, 80, 62, 2), wall(0, 165, 62, 2);
  wall(20, 20, 14, 6), wall(5, 110, 6, 30), wall(36, 210, 10, 10), wall(120, 150, 12, 5),
      wall(100, 60, 20, 30);
  return grid_from_text(rows, 0.05);
}

/// A robot that goes round in a circle, about `centre`, with 90 beams over 270 degrees and 2 cm of noise.
class Robot {
 public:
  explicit Robot(const GridMap& map, std::uint64_t seed) : map_(map), seed_(seed) {}
  Pose truth, odometry;

  void put(double x_m, double y_m) { truth = {x_m, y_m, 0.3}; }
  void drive() {
    const Pose moved{0.05, 0.0, 0.08};
    truth = compose(truth, moved);
    odometry = compose(odometry, moved);
    ++step_;
  }
  Scan scan() const {
    Scan s{.stamp_s = 0.1 * step_, .angle_min_rad = -2.35, .angle_step_rad = 4.7 / 89.0, .range_max_m = 6.0};
    for (std::uint32_t i = 0; i < 90; ++i) {
      const double angle_rad = truth.theta_rad + s.angle_min_rad + i * s.angle_step_rad;
      const double range_m = cast_simulated_ray(map_, truth.x_m, truth.y_m, angle_rad, s.range_max_m).range_m;
      const Normals n = normals(philox(i, step_, Stream::simulated_beams, 0, seed_));
      s.ranges_m.push_back(static_cast<float>(range_m + (range_m < 6.0 ? 0.02 * n.n[0] : 0.0)));
    }
    return s;
  }
  double off_m(const Estimate& e) const { return distance_m(e.pose, truth); }
  /// Drives on, and what the filter says at the end.
  Estimate drive(ParticleFilter& filter, int steps) {
    Estimate e;
    for (int k = 0; k < steps; ++k) drive(), e = filter.step(odometry, scan());
    return e;
  }

 private:
  const GridMap& map_;
  std::uint64_t seed_;
  std::uint32_t step_ = 0;
};

FilterConfig adaptive(std::uint64_t seed) {
  FilterConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = 2;
  c.seed = seed;
  c.min_particles = 100;
  c.max_particles = 20000;
  return c;
}

TEST(Amcl, AGlobalStartFindsTheRobotAndShrinks) {
  const GridMap map = flat();
  for (const std::uint64_t seed : {1, 2, 3}) {
    Robot robot(map, seed);
    robot.put(2.0, 1.8);
    ParticleFilter filter(adaptive(seed), map);
    filter.start_anywhere();
    EXPECT_EQ(robot.drive(filter, 1).particles, 20000u);
    const Estimate e = robot.drive(filter, 59);
    EXPECT_LT(robot.off_m(e), 0.1) << seed;
    EXPECT_LT(e.particles, 1000u) << seed;
    EXPECT_GE(e.particles, 100u) << seed;
    EXPECT_EQ(filter.particles().size(), e.particles);
  }
}

/// Steps until the robot is found again after it was carried off, at most `most`.
int steps_to_find(const FilterConfig& config, std::uint64_t seed, int most, Estimate& last) {
  const GridMap map = flat();
  Robot robot(map, seed);
  robot.put(2.0, 1.8);
  ParticleFilter filter(config, map);
  filter.start_at(robot.truth, 0.1, 0.1, 0.05);
  EXPECT_LT(robot.off_m(robot.drive(filter, 60)), 0.1) << seed;
  robot.put(9.5, 5.4);  // nobody tells the filter
  int found = 0;
  for (int k = 1; k <= most; ++k) {
    last = robot.drive(filter, 1);
    if (robot.off_m(last) > 0.3) found = 0;
    if (robot.off_m(last) < 0.3 && found == 0) found = k;
  }
  return found == 0 ? most + 1 : found;
}

TEST(Amcl, AKidnappedRobotIsFoundByInjection) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Estimate last;
    FilterConfig c = adaptive(seed);
    EXPECT_GT(steps_to_find(c, seed, 150, last), 150) << "not without help: " << seed;
    EXPECT_EQ(last.p_injected, 0.0);
    c.recovery.recovery_alpha_slow = 0.001, c.recovery.recovery_alpha_fast = 0.1;
    c.recovery.recovery_margin = 1.0;
    EXPECT_LE(steps_to_find(c, seed, 200, last), 150) << seed;
    EXPECT_LT(last.particles, 2000u) << seed;  // and shrinks again
  }
}

// With a margin it is found sooner, or a place is found that explains the scans well enough to stay: here
// with seed 4.
TEST(Amcl, AMarginFindsMostOfThemSooner) {
  int found = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Estimate last;
    FilterConfig c = adaptive(seed);
    c.recovery.recovery_alpha_slow = 0.001, c.recovery.recovery_alpha_fast = 0.1;
    found += steps_to_find(c, seed, 60, last) <= 40 ? 1 : 0;
    EXPECT_EQ(last.p_injected, 0.0) << seed;  // and it ends by itself
  }
  EXPECT_GE(found, 4);
}

// Carried off by a metre and a half: too far for the cloud, near enough for a wider one.
TEST(Amcl, AWidenedCloudFindsARobotNearby) {
  const auto off_m = [](const FilterConfig& config, std::uint64_t seed) {
    const GridMap map = flat();
    Robot robot(map, seed);
    robot.put(2.0, 4.8);
    ParticleFilter filter(config, map);
    filter.start_at(robot.truth, 0.1, 0.1, 0.05);
    robot.drive(filter, 40);
    robot.truth = compose(robot.truth, {1.0, 1.1, 0.4});
    return robot.off_m(robot.drive(filter, 60));
  };
  for (const std::uint64_t seed : {1, 2, 3}) {
    FilterConfig c = adaptive(seed);
    c.max_particles = 5000;
    EXPECT_GT(off_m(c, seed), 0.5) << seed;
    c.recovery.expansion_likelihood = 0.5;
    EXPECT_LT(off_m(c, seed), 0.1) << seed;
  }
}

TEST(Amcl, EqualLimitsAreTheFixedFilter) {
  const GridMap map = flat();
  const auto digest = [&](std::int64_t fewest, std::int64_t most, std::int64_t particles) {
    FilterConfig c = adaptive(1);
    c.min_particles = fewest, c.max_particles = most, c.particles = particles;
    Robot robot(map, 1);
    robot.put(2.0, 1.8);
    ParticleFilter filter(c, map);
    filter.start_at(robot.truth, 0.1, 0.1, 0.05);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(robot.drive(filter, 1).particles, 700u);
    return filter.digest();
  };
  const std::string fixed = digest(0, 0, 700);
  EXPECT_EQ(digest(700, 700, 2000), fixed);
  EXPECT_EQ(digest(0, 700, 2000), fixed);
}

// nav2's update triggers: a scan counts once the odometry is so far from where it was at the last one that
// did; between, the pose goes on with the odometry.
TEST(Amcl, ScansWaitForTheirTurnAndThePoseMovesOn) {
  const GridMap map = flat();
  FilterConfig c = adaptive(1);
  c.update_min_d = 0.12, c.update_min_a = 10.0;  // a drive is 5 cm: every third step
  Robot robot(map, 1);
  robot.put(2.0, 1.8);
  ParticleFilter filter(c, map);
  filter.start_at(robot.truth, 0.05, 0.05, 0.02);
  std::string weighted;
  for (int k = 0; k < 13; ++k) {
    const Estimate e = filter.step(robot.odometry, robot.scan());
    weighted += e.weighted ? 'w' : '.';
    EXPECT_LT(robot.off_m(e), 0.08) << k;  // two steps of odometry alone would be 0.1 m
    robot.drive();
  }
  EXPECT_EQ(weighted, "w..w..w..w..w");
  EXPECT_EQ(filter.steps(), 5u);
}

}  // namespace
}  // namespace parloc
