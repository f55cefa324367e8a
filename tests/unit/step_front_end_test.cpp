// What happens before a step, the same for the particle filter, flows and SLAM: a reading that is no number
// is as if it had never been given, wherever it stands, and clocks that stand still do no harm.
#include "common/filter/steps/step_front_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/filter/particle_filter.h"
#include "common/flow/flow_filter.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Any of the three, after a drive.
struct Driven {
  std::string digest;
  Pose end;  ///< In the map frame; of SLAM, which begins at its own origin, from the first scan.
  std::size_t invalid;
};
using Drive = std::function<Driven(const std::vector<LogRecord>& records)>;

template <class Config>
Config on_cpu(Config config) {
  config.backend = BackendChoice::cpu;
  config.threads = 1;
  return config;
}

template <class Filter>
Driven localize(Filter& filter, const std::vector<LogRecord>& records) {
  filter.start_at({1.0, 1.0, 0.0}, 0.05, 0.05, 0.02);
  Pose end;
  for (const LogRecord& r : records) end = filter.step(r.odometry, r.scan).pose;
  return {filter.digest(), end, filter.odometry_invalid()};
}

Driven by_particles(const std::vector<LogRecord>& records) {
  FilterConfig config;
  config.particles = 300;
  ParticleFilter filter(on_cpu(config), test::small_room());
  return localize(filter, records);
}

Driven by_flow(const std::vector<LogRecord>& records) {
  FlowFilterConfig config;
  config.particles = 50;
  FlowFilter filter(FlowMethod::naedh, on_cpu(config), test::small_room());
  return localize(filter, records);
}

Driven by_slam(const std::vector<LogRecord>& records) {
  GridSlamConfig config;
  config.slam.particles = 3;
  config.slam.close_loops = false;
  config.update_min_d = config.update_min_a = 0.0;
  GridSlam slam(on_cpu(config));
  for (const LogRecord& r : records) slam.step(r.odometry, r.scan);
  const Trajectory trajectory = slam.trajectory();
  const Pose end = trajectory.empty() ? Pose{} : compose({1.0, 1.0, 0.0}, trajectory.back().pose);
  return {slam.records().empty() ? "" : slam.digest(), end, slam.odometry_invalid()};
}

struct Case {
  const char* name;
  Drive drive;
};

class StepFrontEnds : public testing::TestWithParam<Case> {
 protected:
  static const std::vector<LogRecord>& records() {
    static const std::vector<LogRecord> scans = test::small_drive(test::small_room(), 30).scans;
    return scans;
  }
};

TEST_P(StepFrontEnds, AReadingThatIsNoNumberIsAsIfItHadNotBeenGiven) {
  const std::vector<std::vector<std::size_t>> places = {{0}, {14}, {0, 1, 2, 13, 14, 29}};
  for (const std::vector<std::size_t>& odd : places)
    for (const Pose& reading :
         {Pose{kNan, 0.0, 0.0}, Pose{0.0, kInfinity, 0.0}, Pose{0.0, 0.0, -kInfinity}}) {
      std::vector<LogRecord> given = records(), left;
      for (std::size_t k = 0; k < given.size(); ++k) {
        if (std::find(odd.begin(), odd.end(), k) == odd.end())
          left.push_back(given[k]);
        else
          given[k].odometry = reading;
      }
      const Driven driven = GetParam().drive(given);
      EXPECT_EQ(driven.digest, GetParam().drive(left).digest) << odd.size();
      EXPECT_EQ(driven.invalid, odd.size());
      EXPECT_TRUE(is_finite(driven.end));
    }
}

TEST_P(StepFrontEnds, NothingButReadingsThatAreNoNumbersIsNoDrive) {
  std::vector<LogRecord> given = records();
  for (LogRecord& r : given) r.odometry = {kNan, kNan, kNan};
  const Driven driven = GetParam().drive(given);
  EXPECT_EQ(driven.digest, GetParam().drive({}).digest);
  EXPECT_EQ(driven.invalid, given.size());
}

TEST_P(StepFrontEnds, StampsThatStandStillDoNoHarm) {
  std::vector<LogRecord> given = records();
  for (LogRecord& r : given) r.stamp_s = r.scan.stamp_s = 0.0;
  const Driven driven = GetParam().drive(given);
  const Pose truth = compose({1.0, 1.0, 0.0}, given.back().odometry);
  EXPECT_LT(distance_m(driven.end, truth), 0.1);
  EXPECT_LT(turn_rad(driven.end, truth), 0.05);
}

INSTANTIATE_TEST_SUITE_P(All, StepFrontEnds,
                         testing::Values(Case{"particles", by_particles}, Case{"flow", by_flow},
                                         Case{"slam", by_slam}),
                         [](const auto& one) { return one.param.name; });

// Any front end alone.
// A glitch, a reset and a reading of any size are as if the robot had gone on as before.
TEST_P(StepFrontEnds, AReadingThatNoRobotMakesDoesNoHarm) {
  for (const double far_m : {10.0, 1e3, 1e6, 1e300}) {
    std::vector<LogRecord> given = records();
    given[9].odometry.x_m = given[19].odometry.y_m = far_m;
    const Driven driven = GetParam().drive(given);
    const Pose truth = compose({1.0, 1.0, 0.0}, given.back().odometry);
    EXPECT_LT(distance_m(driven.end, truth), 0.15) << far_m;
    EXPECT_LT(turn_rad(driven.end, truth), 0.06) << far_m;
    EXPECT_EQ(driven.invalid, 0u);
  }
  std::vector<LogRecord> reset = records();
  const Pose start = reset[12].odometry, end = reset.back().odometry;
  for (std::size_t k = 12; k < reset.size(); ++k) {
    reset[k].odometry = relative(reset[k].odometry, start);
    reset[k].odometry.x_m += 50.0;
  }
  const Driven driven = GetParam().drive(reset);
  EXPECT_LT(distance_m(driven.end, compose({1.0, 1.0, 0.0}, end)), 0.15);
}

Movement move(StepFrontEnd& front_end, double stamp_s, const Pose& odometry) {
  return front_end.move_to(front_end.take_odometry(stamp_s, odometry)->pose);
}

TEST(StepFrontEnd, AJumpIsCountedAndGuessed) {
  FilterConfig config;
  StepFrontEnd front_end(config);
  EXPECT_EQ(move(front_end, 0.0, {5.0, 5.0, 0.0}).increment.trans_m, 0.0);  // the first is none
  EXPECT_FALSE(move(front_end, 0.2, {5.1, 5.0, 0.0}).guessed);
  const Movement jump = move(front_end, 0.4, {9.1, 5.0, 0.0});
  EXPECT_TRUE(jump.guessed);
  EXPECT_NEAR(jump.increment.trans_m, 0.1, 1e-9);  // as before
  EXPECT_NEAR(jump.elapsed_s, 0.2, 1e-9);
  EXPECT_NEAR(move(front_end, 0.6, {9.2, 5.0, 0.0}).increment.trans_m, 0.1, 1e-9);
  EXPECT_EQ(front_end.continuous().jumps(), 1u);
}

// A robot on mecanum wheels goes sideways, 4 mm per scan.
TEST(StepFrontEnd, SmallStepsAreKeptUntilTheyCount) {
  for (const MotionForm form : {MotionForm::seed, MotionForm::thrun, MotionForm::omni}) {
    FilterConfig config;
    config.motion.form = form;
    StepFrontEnd front_end(config);
    Pose reached{1.0, 1.0, 0.3};
    for (int k = 0; k <= 500; ++k)
      reached = moved(reached, move(front_end, 0.1 * k, {1.0, 1.0 + 0.004 * k, 0.3}).increment);
    EXPECT_NEAR(reached.x_m, 1.0, 0.011);
    EXPECT_NEAR(reached.y_m, 3.0, 0.011);
    EXPECT_NEAR(reached.theta_rad, 0.3, 1e-9);
  }
}

TEST(StepFrontEnd, OdometryThatComesLateIsMovedToTheScan) {
  FilterConfig config;
  config.motion.odometry_delay_s = 0.15;
  StepFrontEnd front_end(config);
  Pose now;
  for (int k = 0; k < 20; ++k) now = front_end.take_odometry(0.1 * k, {0.5 * 0.1 * k, 0.0, 0.0})->pose;
  EXPECT_NEAR(now.x_m, 0.5 * (1.9 + 0.15), 1e-6);  // 0.5 m/s
}

TEST(StepFrontEnd, OdometryOutOfScaleIsPutRight) {
  FilterConfig config;
  config.motion.odometry_scale_drive = 1.1, config.motion.odometry_scale_turn = 0.5;
  StepFrontEnd front_end(config);
  const Pose first = front_end.take_odometry(0.0, {1.0, 2.0, 0.0})->pose;
  EXPECT_EQ(first.x_m, 1.0);
  front_end.add_odometry(0.05, {1.1, 2.0, 0.0});  // read ahead
  EXPECT_NEAR(front_end.take_odometry(0.1, {1.2, 2.0, 0.0})->pose.x_m, 1.22, 1e-12);
  const Pose turned = front_end.take_odometry(0.2, {1.2, 2.0, 0.4})->pose;
  EXPECT_NEAR(turned.x_m, 1.22, 1e-12);
  EXPECT_NEAR(turned.theta_rad, 0.2, 1e-12);
}

TEST(StepFrontEnd, AScanCountsAfterEnoughOfEither) {
  FilterConfig config;
  StepFrontEnd front_end(config);
  const std::optional<Pose> before = Pose{1.0, 1.0, 3.1};
  EXPECT_TRUE(front_end.moved_enough(before, *before));  // both 0: every scan
  config.update_min_d = 0.2, config.update_min_a = 0.3;
  EXPECT_FALSE(front_end.moved_enough(before, *before));
  EXPECT_FALSE(front_end.moved_enough(before, {1.1, 1.1, -3.1}));  // 0.14 m, 0.083 rad across the wrap
  EXPECT_TRUE(front_end.moved_enough(before, {1.21, 1.0, 3.1}));
  EXPECT_TRUE(front_end.moved_enough(before, {1.0, 1.0, -2.8}));
  EXPECT_TRUE(front_end.moved_enough(std::nullopt, {}));
}

}  // namespace
}  // namespace parloc
