// Odometry of two wheels: the check values of the published error model, and that a simulated drive has them.
#include "common/simulator/wheel_odometry.h"

#include <array>

#include "common/math/portable64.h"
#include "tests/unit/simulated.h"

namespace parloc {
namespace {

constexpr double kWheelBase_m = 0.160;

/// SPEC 1.6: standard deviations of a 5 cm wheel arc, and of the heading after 1 m and 0.2 m.
struct Check {
  double kappa_m, arc_m, heading_1_m_rad, heading_02_m_rad;
};
constexpr std::array<Check, 3> kChecks{{{1e-6, 0.000223607, 0.00883883, 0.00395285},
                                        {1e-4, 0.00223607, 0.0883883, 0.0395285},
                                        {5e-3, 0.0158114, 0.625, 0.279508}}};

double heading_after(double length_m, double kappa_m, double left, double right) {
  const WheelArcs arcs = with_error(wheel_arcs(length_m, 0.0, kWheelBase_m), kappa_m, left, right);
  return (arcs.right_m - arcs.left_m) / kWheelBase_m;
}

TEST(WheelOdometry, ErrorsOfOneStepAreThePublishedOnes) {
  for (const Check& c : kChecks) {
    const WheelArcs arcs = with_error({0.05, -0.05}, c.kappa_m, 1.0, -1.0);
    EXPECT_NEAR(arcs.left_m - 0.05, c.arc_m, 1e-6 * c.arc_m + 5e-10);  // the table has 6 digits
    EXPECT_NEAR(arcs.right_m + 0.05, -c.arc_m, 1e-6 * c.arc_m + 5e-10);
    // Of two independent wheels: the root of the sum of squares of what each alone does.
    const double one = heading_after(1.0, c.kappa_m, 1.0, 0.0), other = heading_after(1.0, c.kappa_m, 0, 1);
    EXPECT_NEAR(std::hypot(one, other), c.heading_1_m_rad, 1e-6 * c.heading_1_m_rad);
    EXPECT_NEAR(std::hypot(heading_after(0.2, c.kappa_m, 1.0, 0.0), heading_after(0.2, c.kappa_m, 0, 1)),
                c.heading_02_m_rad, 2e-6 * c.heading_02_m_rad);
  }
}

TEST(WheelOdometry, ArcsTakeTheRobotWhereItGoes) {
  const Pose from{1.0, -2.0, 3.0};
  const WheelArcs arcs = wheel_arcs(0.3, 0.5, kWheelBase_m);
  const Pose to = rolled(from, arcs, kWheelBase_m);
  EXPECT_NEAR(along_heading(from, to), 0.3, 1e-12);
  EXPECT_NEAR(wrap64(to.theta_rad - from.theta_rad), 0.5, 1e-12);
  EXPECT_LT(to.theta_rad, 0.0);  // wrapped
  const Pose back = rolled(to, wheel_arcs(-0.3, -0.5, kWheelBase_m), kWheelBase_m);
  expect_near(back, from, 1e-12, 1e-12);
  EXPECT_LT(along_heading({0, 0, 0}, {-0.1, 0, 0}), 0.0);  // backwards
}

Scenario straight_on_wheels(double kappa_m, double odometry_hz, std::uint64_t seed) {
  Scenario s = straight_10_m();
  s.path.points[1].x_m = 3.0;
  s.path.speed_mps = 0.5;
  s.scan_rate_hz = 1.0;
  s.seed = seed;
  s.odometry.rate_hz = odometry_hz;
  s.odometry.errors = OdometryErrors::wheels;
  s.odometry.kappa_m = kappa_m;
  s.odometry.wheel_base_m = kWheelBase_m;
  return s;
}

// The spread after 1 m does not depend on how often the wheels are read.
TEST(WheelOdometry, ASimulatedMetreHasTheSpread) {
  const GridMap map = corridor();
  constexpr int runs = 400;
  for (const double hz : {5.0, 50.0}) {
    std::vector<double> heading_rad, along_m;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const SimulatedLog log = simulate(straight_on_wheels(1e-6, hz, seed), map);
      heading_rad.push_back(log.records.back().odometry.theta_rad);
      along_m.push_back(log.records.back().odometry.x_m - 1.0);
    }
    // A sample standard deviation is off by sigma / sqrt(2 n) itself: four of these.
    const double tolerance = 4.0 / std::sqrt(2.0 * runs);
    EXPECT_NEAR(deviation(heading_rad) / kChecks[0].heading_1_m_rad, 1.0, tolerance) << hz << " Hz";
    EXPECT_NEAR(deviation(along_m) / std::sqrt(0.5e-6), 1.0, tolerance) << hz << " Hz";
    EXPECT_NEAR(mean(heading_rad), 0.0, 4.0 * kChecks[0].heading_1_m_rad / std::sqrt(double{runs}));
  }
}

// Turning in place rolls both wheels by half the base per radian.
TEST(WheelOdometry, WithoutErrorItIsTheTruth) {
  Scenario s = spin();
  s.lidar.beams = 1;
  s.odometry.errors = OdometryErrors::wheels;
  s.odometry.kappa_m = 0.0;
  const SimulatedLog log = simulate(s, corridor());
  const Pose start = log.truth.front().pose, end = log.truth.back().pose;
  const Pose expected = relative(end, start), got = scans_of(log).back().odometry;
  // Where a turn ends within a step, mid-point integration drives a hair's breadth off.
  EXPECT_NEAR(got.x_m, expected.x_m, 1e-3);
  EXPECT_NEAR(got.y_m, expected.y_m, 1e-3);
  EXPECT_NEAR(wrap64(got.theta_rad - expected.theta_rad), 0.0, 1e-9);
}

}  // namespace
}  // namespace parloc
