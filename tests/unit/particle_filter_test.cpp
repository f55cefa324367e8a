// The filter as a program that links the library meets it: starts, steps, counts, and what it refuses.
#include "common/filter/particle_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/unit/expect.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

FilterConfig small_config() {
  FilterConfig c;
  c.particles = 500;
  c.threads = 1;
  c.backend = BackendChoice::cpu;
  return c;
}

FilterConfig every_half_metre() {
  FilterConfig c = small_config();
  c.update_min_d = 0.5;
  c.update_min_a = 10.0;
  return c;
}

class Filter : public testing::Test {
 protected:
  const GridMap room = test::small_room();
  const test::SmallDrive drive = test::small_drive(room, 30);
  const Pose start = drive.truth.front().pose;

  ParticleFilter started(const FilterConfig& config) const {
    ParticleFilter filter(config, room);
    filter.start_at(start, 0.1, 0.1, 0.05);
    return filter;
  }
};

TEST_F(Filter, TracksWithEveryModelAndScheme) {
  for (const SensorModel model : {SensorModel::gaussian, SensorModel::beam, SensorModel::likelihood_field}) {
    for (const ResampleScheme scheme :
         {ResampleScheme::systematic, ResampleScheme::stratified, ResampleScheme::residual,
          ResampleScheme::multinomial, ResampleScheme::multinomial_linear}) {
      FilterConfig config = small_config();
      config.sensor = default_sensor(model);
      config.resample.scheme = scheme;
      ParticleFilter filter = started(config);
      Estimate e;
      for (const LogRecord& r : drive.scans) e = filter.step(r.odometry, r.scan);
      EXPECT_LT(distance_m(e.pose, drive.truth.back().pose), 0.1)  // a cell of the map
          << static_cast<int>(model) << " " << static_cast<int>(scheme);
      EXPECT_TRUE(e.weighted);
      EXPECT_FALSE(e.lost);
      EXPECT_NEAR(e.mean.weight, 1.0, 1e-12);
    }
  }
}

TEST_F(Filter, OdometryThatIsNotFiniteIsSkippedAndCounted) {
  ParticleFilter filter = started(small_config());
  const Estimate before = filter.step(drive.scans[0].odometry, drive.scans[0].scan);
  const std::string digest = filter.digest();
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const Estimate e = filter.step({bad, 0.0, 0.0}, drive.scans[1].scan);
    EXPECT_EQ(e.pose.x_m, before.pose.x_m);
  }
  EXPECT_EQ(filter.odometry_invalid(), 2u);
  EXPECT_EQ(filter.steps(), 1u);
  EXPECT_EQ(filter.digest(), digest);
}

TEST_F(Filter, AJumpOfTheOdometryIsCountedAndSpreadsTheParticles) {
  ParticleFilter filter = started(small_config());
  filter.step(drive.scans[0].odometry, drive.scans[0].scan);
  Pose far = drive.scans[1].odometry;
  far.x_m += 3.0;
  filter.step(far, Scan{});  // no beams: prediction only, so the spread stays
  EXPECT_EQ(filter.odometry_jumps(), 1u);
  double most = 0.0, least = 1e9;
  for (const Particle& p : filter.particles()) {
    most = std::max<double>(most, p.x_m);
    least = std::min<double>(least, p.x_m);
  }
  // It stays where the robot was going, and knows that it may be some decimetres off: sigma is 0.1 m and
  // more.
  EXPECT_GT(most - least, 0.5);
  EXPECT_LT(most - least, 1.5);
}

TEST_F(Filter, WithoutEnoughBeamsItOnlyPredicts) {
  ParticleFilter filter = started(small_config());
  Scan few = drive.scans[0].scan;
  few.ranges_m.resize(4);  // min_beams is 5
  const Estimate e = filter.step(drive.scans[0].odometry, few);
  EXPECT_FALSE(e.weighted);
  EXPECT_FALSE(e.resampled);
}

TEST_F(Filter, StepsBelowTheUpdateThresholdsAreDeadReckoning) {
  ParticleFilter filter = started(every_half_metre());
  std::size_t weighted = 0;
  Estimate e;
  for (const LogRecord& r : drive.scans) {
    e = filter.step(r.odometry, r.scan);
    weighted += e.weighted ? 1 : 0;
  }
  EXPECT_EQ(weighted, filter.steps());
  EXPECT_EQ(weighted, 5u);  // a quarter circle of 2.18 m: at 0 and every half metre
  EXPECT_LT(distance_m(e.pose, drive.truth.back().pose), 0.1);
}

TEST_F(Filter, OneParticleIsAFilterToo) {
  FilterConfig config = small_config();
  config.particles = 1;
  ParticleFilter filter = started(config);
  for (const LogRecord& r : drive.scans) {
    const Estimate e = filter.step(r.odometry, r.scan);
    EXPECT_TRUE(std::isfinite(e.pose.x_m) && std::isfinite(e.pose.theta_rad));
    EXPECT_EQ(e.n_eff, 1.0);
  }
}

TEST_F(Filter, RefusesWhatCannotBe) {
  ParticleFilter filter(small_config(), room);
  error_of([&] { filter.start_at({100.0, 0.0, 0.0}, 0.1, 0.1, 0.1); }, ErrorKind::input);
  error_of([&] { filter.start_at({NAN, 0.0, 0.0}, 0.1, 0.1, 0.1); }, ErrorKind::input);
  error_of([&] { filter.step({}, drive.scans[0].scan); }, ErrorKind::usage);  // not started
  FilterConfig none = small_config();
  none.particles = 0;
  error_of([&] { ParticleFilter(none, room); }, ErrorKind::config);
  GridMap walls = room;
  for (Cell& c : walls.cells) c = Cell::occupied;
  error_of([&] { ParticleFilter(small_config(), walls); }, ErrorKind::input);
}

// The same start again is the same run: nothing of the first one is left.
TEST_F(Filter, StartingAgainForgetsEverything) {
  ParticleFilter filter = started(small_config());
  for (const LogRecord& r : drive.scans) filter.step(r.odometry, r.scan);
  const std::string digest = filter.digest();
  filter.start_at(start, 0.1, 0.1, 0.05);
  EXPECT_EQ(filter.beam_counts().total, 0u);
  for (const LogRecord& r : drive.scans) filter.step(r.odometry, r.scan);
  EXPECT_EQ(filter.digest(), digest);
}

// ---- several LiDARs ---------------------------------------------------------------------------------------

/// The drive's LiDAR cut in two: beams 0 to 29 and 30 to 60, on mounts of their own.
Scan part_of(const Scan& scan, std::size_t first, std::size_t count, const std::string& name) {
  Scan part = scan;
  part.sensor = name;
  part.angle_min_rad += static_cast<double>(first) * scan.angle_step_rad;
  part.ranges_m = {scan.ranges_m.begin() + static_cast<long>(first),
                   scan.ranges_m.begin() + static_cast<long>(first + count)};
  return part;
}
/// The same beams, by a device that is turned by `yaw_rad`.
Scan remounted(Scan scan, double yaw_rad) {
  scan.T_base_sensor.theta_rad += yaw_rad;
  scan.angle_min_rad -= yaw_rad;
  return scan;
}

TEST_F(Filter, TwoLidarsAreWorthOneWithTheBeamsOfBoth) {
  for (const SensorModel model : {SensorModel::gaussian, SensorModel::beam, SensorModel::likelihood_field}) {
    FilterConfig config = small_config();
    config.sensor = default_sensor(model);
    config.sensor.tempering = 0.2;    // effective_beams are those of a scan, and two scans are worth more
    config.resample.threshold = 0.0;  // never: what is compared is the weights
    ParticleFilter one = started(config), two = started(config);
    const LogRecord& r = drive.scans[0];
    const Estimate whole = one.step(r.odometry, r.scan);
    two.step(r.odometry, remounted(part_of(r.scan, 0, 30, "front"), 0.4));
    const Estimate both = two.step(r.odometry, remounted(part_of(r.scan, 30, 31, "rear"), 2.5));

    // Beams are rounded to 2^-16 nat (at most 61 half steps: 5e-4) and weights to 2^-40, twice; directions of
    // a remounted sensor differ in the last bit of float32, which likelihoods of 0.1 m see as 1e-6.
    constexpr double tolerance = 2e-3;
    expect_near(both.mean.mean, whole.mean.mean, 1e-4, 1e-4);
    EXPECT_NEAR(both.n_eff / whole.n_eff, 1.0, tolerance);
    EXPECT_LT(whole.n_eff, 400.0);  // the scan said something
    const std::vector<Particle> a = one.particles(), b = two.particles();
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].x_m, b[i].x_m);  // the second step at the same time moves nothing
      EXPECT_EQ(a[i].theta_rad, b[i].theta_rad);
      EXPECT_NEAR(b[i].weight, a[i].weight, tolerance * a[i].weight + 1e-7);
    }
  }
}

TEST_F(Filter, CountsBeamsByLidar) {
  FilterConfig config = small_config();
  config.lidars = {{.name = "rear", .max_beams = 10}};
  ParticleFilter filter = started(config);
  std::size_t rear_total = 0;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const LogRecord& r = drive.scans[k];
    filter.step(r.odometry, part_of(r.scan, 0, 30, "front"));
    const std::size_t size = k == 3 ? 2 : 31 - k % 2;  // changing sizes; 2 are too few
    rear_total += size;
    filter.step(r.odometry, part_of(r.scan, 30, size, "rear"));
  }
  ASSERT_EQ(filter.lidars_used().size(), 2u);
  const LidarUse& front = filter.lidars_used()[0];
  const LidarUse& rear = filter.lidars_used()[1];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.max_beams, 100);
  EXPECT_EQ(front.scans, 30u);
  EXPECT_EQ(front.beams.total, 900u);
  EXPECT_EQ(front.beams.considered, 900u);
  EXPECT_EQ(front.beams.used + front.beams.rejected(), 900u);
  EXPECT_EQ(rear.name, "rear");
  EXPECT_EQ(rear.max_beams, 10);
  EXPECT_EQ(rear.smallest, 2u);
  EXPECT_EQ(rear.largest, 31u);
  EXPECT_EQ(rear.too_few, 1u);
  EXPECT_EQ(rear.beams.total, rear_total);
  EXPECT_EQ(rear.beams.considered, 29u * 10u + 2u);
  EXPECT_EQ(filter.beam_counts().total, 900u + rear_total);
}

TEST_F(Filter, UpdateThresholdsHoldForEachLidarOfItsOwn) {
  ParticleFilter filter = started(every_half_metre());
  for (const LogRecord& r : drive.scans) {
    filter.step(r.odometry, part_of(r.scan, 0, 30, "front"));
    filter.step(r.odometry, part_of(r.scan, 30, 31, "rear"));
  }
  for (const LidarUse& lidar : filter.lidars_used()) EXPECT_EQ(lidar.scans, 5u) << lidar.name;
}

TEST_F(Filter, LidarsOfDifferentReachTrack) {
  ParticleFilter filter = started(small_config());
  Estimate e;
  for (const LogRecord& r : drive.scans) {
    Scan near = part_of(r.scan, 0, 30, "near");
    near.range_max_m = 2.0;
    filter.step(r.odometry, near);
    e = filter.step(r.odometry, part_of(r.scan, 30, 31, "far"));
  }
  EXPECT_LT(distance_m(e.pose, drive.truth.back().pose), 0.1);  // a cell of the map
  EXPECT_GT(filter.lidars_used()[0].beams.misses, 0u);
}

// ---- scans that take time ---------------------------------------------------------------------------------

TEST_F(Filter, AStandingRobotIsDeskewedToTheBit) {
  const auto digest = [&](double scan_time_s) {
    FilterConfig config = small_config();
    config.scan.scan_time = scan_time_s;
    ParticleFilter filter = started(config);
    for (int k = 0; k < 5; ++k) {
      Scan scan = drive.scans[0].scan;
      scan.stamp_s = 100.0 + 0.1 * k;
      filter.step(drive.scans[0].odometry, scan);
    }
    EXPECT_EQ(filter.lidars_used()[0].moving, scan_time_s > 0 ? 5u : 0u);
    EXPECT_EQ(filter.lidars_used()[0].unknown_motion, scan_time_s > 0 ? 1u : 0u);  // the first: one reading
    return filter.digest();
  };
  EXPECT_EQ(digest(0.1), digest(0.0));
}

TEST_F(Filter, OdometryBetweenStepsTellsTheMotion) {
  FilterConfig config = small_config();
  config.scan.scan_time = 0.1;
  const auto end_point = [&](bool told) {
    ParticleFilter filter = started(config);
    if (told) filter.add_odometry(100.1, {0, 0, 0.2});
    filter.step({0, 0, 0}, drive.scans[0].scan);
    EXPECT_EQ(filter.lidars_used()[0].unknown_motion, told ? 0u : 1u);
    return filter.end_points(drive.scans[0].scan).back();
  };
  const EndPoint still = end_point(false), turning = end_point(true);
  // The last beam was taken 0.2 rad farther left.
  EXPECT_NEAR(std::atan2(turning.y_m, turning.x_m) - std::atan2(still.y_m, still.x_m), 0.2, 1e-6);
  ParticleFilter filter = started(config);
  filter.add_odometry(100.1, {0, 0, 0.2});
  filter.start_at(start, 0.1, 0.1, 0.05);  // forgets it
  filter.step({0, 0, 0}, drive.scans[0].scan);
  EXPECT_EQ(filter.lidars_used()[0].unknown_motion, 1u);
}

}  // namespace
}  // namespace parloc
