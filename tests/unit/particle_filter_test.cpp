// The filter as a program that links the library meets it: starts, steps, counts, and what it refuses.
#include "common/filter/particle_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error.h"
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
  double distance_m(const Pose& a, const Pose& b) const { return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }
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
  EXPECT_GT(most - least,
            3.0);  // sigma is alpha3 * 3 m, three times over for a jump of three times the limit
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
  FilterConfig config = small_config();
  config.update_min_d = 0.5;
  config.update_min_a = 10.0;
  ParticleFilter filter = started(config);
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
  const auto kind_of = [](const auto& action) {
    try {
      action();
    } catch (const Error& e) {
      return e.kind();
    }
    ADD_FAILURE() << "no error";
    return ErrorKind::internal;
  };
  ParticleFilter filter(small_config(), room);
  EXPECT_EQ(kind_of([&] { filter.start_at({100.0, 0.0, 0.0}, 0.1, 0.1, 0.1); }), ErrorKind::input);
  EXPECT_EQ(kind_of([&] { filter.start_at({NAN, 0.0, 0.0}, 0.1, 0.1, 0.1); }), ErrorKind::input);
  EXPECT_EQ(kind_of([&] { filter.step({}, drive.scans[0].scan); }), ErrorKind::internal);  // not started
  FilterConfig none = small_config();
  none.particles = 0;
  EXPECT_EQ(kind_of([&] { ParticleFilter(none, room); }), ErrorKind::config);
  GridMap walls = room;
  for (Cell& c : walls.cells) c = Cell::occupied;
  EXPECT_EQ(kind_of([&] { ParticleFilter(small_config(), walls); }), ErrorKind::input);
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

}  // namespace
}  // namespace parloc
