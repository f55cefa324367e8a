// The drive of a simulated robot along its path, and the shipped paths.
#include <algorithm>

#include "common/simulator/drive.h"

#include "tests/unit/simulated.h"

namespace parloc {
namespace {

TEST(Drive, the_papers_path_is_17_m_long) {
  const Scenario scenario = paper();
  EXPECT_NEAR(path_length_m(scenario.path), 17.0, 0.02 * 17.0);
  double driven_m = 0.0;
  const SimulatedLog log = simulate(scenario, fine_hall());
  for (std::size_t k = 1; k < log.truth.size(); ++k)
    driven_m += distance_m(log.truth[k].pose, log.truth[k - 1].pose);
  EXPECT_NEAR(driven_m, 17.0, 0.02 * 17.0);
}

TEST(Drive, stops_to_turn) {
  const Scenario scenario = paper();
  const Drive drive = plan_drive(scenario.path);
  int turns = 0;
  for (const DrivePhase& phase : drive.phases) {
    const bool moves = phase.dx_m != 0.0 || phase.dy_m != 0.0;
    EXPECT_FALSE(moves && phase.turn_rad != 0.0);
    turns += phase.turn_rad != 0.0 ? 1 : 0;
  }
  EXPECT_EQ(turns, 4);
  // The same in the truth: between scans inside one phase, heading and place never change together.
  int mixed = 0, turning = 0;
  const double dt_s = 0.1;
  for (double t = dt_s; t < drive.duration_s(); t += dt_s) {
    const Pose step = relative(pose_at(drive, t), pose_at(drive, t - dt_s));
    const bool moved = std::hypot(step.x_m, step.y_m) > 1e-9;
    const bool turned = std::fabs(step.theta_rad) > 1e-9;
    mixed += moved && turned ? 1 : 0;
    turning += turned ? 1 : 0;
    EXPECT_LE(std::hypot(step.x_m, step.y_m), scenario.path.speed_mps * dt_s + 1e-9);
    EXPECT_LE(std::fabs(step.theta_rad), scenario.path.turn_rate_rad_s * dt_s + 1e-9);
  }
  EXPECT_LE(mixed, 4);  // a turn that begins or ends within a step: at most one per stop, as it pauses before
  EXPECT_GE(turning, 75);  // 2 x 53.13 and 2 x 90 degrees at 0.6 rad/s are 8.3 s
}

TEST(Drive, holds_its_ends_and_faces_its_first_leg) {
  WaypointPath path;
  path.points = {{1.0, 1.0, 0.0}, {1.0, 3.0, 0.0}, {-1.0, 3.0, 2.0}};
  path.speed_mps = 1.0;
  path.turn_rate_rad_s = kDeg * 90.0;
  const Drive drive = plan_drive(path);
  EXPECT_NEAR(drive.duration_s(), 2.0 + 1.0 + 2.0 + 2.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, -5.0).theta_rad, 90.0 * kDeg, 1e-12);
  EXPECT_NEAR(pose_at(drive, 2.5).theta_rad, 135.0 * kDeg, 1e-12);
  EXPECT_NEAR(pose_at(drive, 4.0).x_m, 0.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, 99.0).x_m, -1.0, 1e-12);
}

TEST(ShippedPaths, keep_clear_of_walls) {
  for (const char* name : {"paz2012", "office", "spin", "two_lidars"}) {
    const Scenario scenario = read_scenario(kRoot + "configs/" + name + "_scenario.yaml");
    for (const std::string& map_path : {scenario.map_path, scenario.localization_map_path}) {
      const GridMap map = read_map(map_path);
      const Drive drive = plan_drive(scenario.path);
      double clearance_m = 1.0;
      for (double t = 0.0; t < drive.duration_s(); t += 0.2) {
        const Pose pose = pose_at(drive, t);
        for (int k = 0; k < 36; ++k) {
          const SimulatedHit wall = cast_simulated_ray(map, pose.x_m, pose.y_m, k * 10.0 * kDeg, 1.0);
          clearance_m = std::min(clearance_m, wall.range_m);
        }
      }
      EXPECT_GE(clearance_m, 0.3) << map_path;  // a small robot fits
    }
    const double minutes = plan_drive(scenario.path).duration_s() / 60.0;
    if (std::string(name) == "office") {
      EXPECT_NEAR(minutes, 5.0, 0.5);
    }
  }
}

TEST(Drive, spins_on_the_spot) {
  WaypointPath path;
  path.points = {{1.0, 1.0, 0.5, -7.0}, {3.0, 1.0, 0.0, 1.0}};
  path.speed_mps = 1.0;
  path.turn_rate_rad_s = 2.0;
  const Drive drive = plan_drive(path);
  const double back_rad = 7.0 - 2.0 * std::numbers::pi;  // the short way to the next point
  EXPECT_NEAR(drive.duration_s(), 0.5 + 3.5 + back_rad / 2.0 + 2.0 + 0.5, 1e-12);
  EXPECT_NEAR(pose_at(drive, 1.5).theta_rad, -2.0, 1e-12);
  EXPECT_NEAR(pose_at(drive, 4.0).theta_rad, -back_rad, 1e-12);
  EXPECT_NEAR(pose_at(drive, drive.duration_s()).theta_rad, 1.0, 1e-12);
  EXPECT_EQ(pose_at(drive, 3.0).x_m, 1.0);
}

}  // namespace
}  // namespace parloc
