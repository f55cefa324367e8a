// What a robot may give a filter that no log has: maps made by a program, scans that are no numbers, come
// twice or late, LiDARs with other names. All of it is refused or told in one line.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/filter/particle_filter.h"
#include "common/flow/flow_filter.h"
#include "common/localize/localizer.h"
#include "common/map/map_reader.h"
#include "common/map/segment_map.h"
#include "common/search/global_search.h"
#include "common/slam/grid_slam.h"
#include "tests/unit/expect.h"
#include "tests/unit/live_drive.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Config>
Config on_cpu(Config config) {
  config.backend = BackendChoice::cpu;
  config.threads = 1;
  return config;
}
FilterConfig small_filter() {
  FilterConfig c;
  c.particles = 300;
  return on_cpu(c);
}

class Live : public LiveDrive {};

TEST_F(Live, AMapThatIsNoneIsRefusedByAllThatTakeOne) {
  const auto broken = [&](auto&& breaks) {
    GridMap map = room;
    map.name = "made up";
    breaks(map);
    return map;
  };
  const std::vector<std::pair<GridMap, std::string>> maps = {
      {broken([](GridMap& m) { m.cells.resize(10); }), "60 x 40 = 2400 cells, got 10"},
      {broken([](GridMap& m) { m.width = 0; }), "sides of 1 to 32767 cells, got 0 x 40"},
      {broken([](GridMap& m) { m.height = 32768; }), "got 60 x 32768"},
      {broken([](GridMap& m) { m.cells[7] = static_cast<Cell>(100); }), "free, occupied or unknown"},
      {broken([](GridMap& m) { m.resolution_m = 0.0; }), "a resolution of 0.0001 to 1000 m, got 0"},
      {broken([](GridMap& m) { m.resolution_m = kNan; }), "got nan"},
      {broken([](GridMap& m) { m.T_map_grid.x_m = kNan; }), "an origin that is finite, got (nan, 0, 0)"},
      {broken([](GridMap& m) {
         m.walls.push_back({0.0f, 0.0f, 1.0f, NAN});
       }),
       "walls that are finite"}};
  validate(room);
  for (const auto& [map, part] : maps) {
    SCOPED_TRACE(part);
    const GridMap& bad = map;
    const std::vector<std::string> said = {
        error_of([&] { validate(bad); }), error_of([&] { ParticleFilter(small_filter(), bad); }),
        error_of([&] { FlowFilter(FlowMethod::ekf, on_cpu(FlowFilterConfig()), bad); }),
        error_of([&] { Localizer(on_cpu(LocalizerConfig()), bad); }),
        error_of([&] { GlobalSearch(bad, {}, on_cpu(ComputeConfig())); })};
    for (const std::string& text : said) expect_parts(text, {"made up: expected a map with ", part});
  }
  error_of([&] { write_map(testing::TempDir() + "none.yaml", maps[4].first); });
  error_of([&] { (void)segment_yaml_of(maps[7].first); });
  error_of([&] { GlobalSearch(room, {}, {.backend = BackendChoice::cpu, .threads = -1}); },
           ErrorKind::config);
}

// A LiDAR that hangs upside down at the back and of which the log says nothing.
TEST_F(Live, AGlobalSearchKnowsHowLidarsAreMounted) {
  StepConfig config;
  config.lidars = {{.name = "robotlaser1", .x = -0.5, .y = 0.1, .yaw = 2.0, .upside_down = true}};
  const Pose base{3.3, 2.1, 0.4}, lidar = compose(base, {-0.5, 0.1, 2.0});
  Scan scan = drive.scans[0].scan;
  scan.range_max_m = 12.0;
  scan.angle_step_rad = 2.0 * M_PI / 60.0;
  scan.angle_min_rad = 0.0;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double angle_rad = lidar.theta_rad - static_cast<double>(i) * scan.angle_step_rad;
    scan.ranges_m[i] =
        static_cast<float>(cast_simulated_ray(room, lidar.x_m, lidar.y_m, angle_rad, 12.0).range_m);
  }
  GlobalSearch search(room, {}, on_cpu(ComputeConfig()));
  const SearchResult found = search.search(scan, config);
  ASSERT_FALSE(found.hypotheses.empty());
  EXPECT_LT(distance_m(found.hypotheses[0].pose, base), 0.15);
  EXPECT_LT(turn_rad(found.hypotheses[0].pose, base), 0.05);
}

TEST_F(Live, AScanBetweenThresholdsMovesAllThatIsSaid) {
  FilterConfig config = small_filter();
  config.update_min_d = 0.5;
  ParticleFilter filter = started(config);
  const Estimate before = step(filter, 0), after = step(filter, 3);
  ASSERT_FALSE(after.weighted);
  EXPECT_EQ(filter.why_skipped(), "too little motion");
  const Pose motion = relative(drive.scans[3].odometry, drive.scans[0].odometry);
  expect_equal(after.pose, compose(before.pose, motion));
  expect_equal(after.mean.mean, compose(before.mean.mean, motion));
  expect_equal(after.cluster.mean, compose(before.cluster.mean, motion));
  EXPECT_EQ(after.mean.covariance.v[0], before.mean.covariance.v[0]);
  EXPECT_EQ(after.stamp_s, drive.scans[3].scan.stamp_s);
}

// A threshold of 0 is none: update_min_d alone used to let every scan through.
TEST_F(Live, OneThresholdAloneCounts) {
  FilterConfig by_way = small_filter(), by_turn = small_filter();
  by_way.update_min_d = 0.3;
  by_turn.update_min_a = 0.3;
  ParticleFilter way = started(by_way), turn = started(by_turn), all = started(small_filter());
  for (std::size_t k = 0; k < drive.scans.size(); ++k)
    for (ParticleFilter* filter : {&way, &turn, &all}) step(*filter, k);
  EXPECT_EQ(way.steps(), 7u);   // 2.1 m in 20 steps of 11 cm: every third
  EXPECT_EQ(turn.steps(), 5u);  // 1.4 rad in steps of 0.075: every fourth
  EXPECT_EQ(all.steps(), 20u);
}

TEST_F(Live, NumbersOfAScanThatAreNoneAreRefusedAndChangeNothing) {
  ParticleFilter filter = started(small_filter());
  step(filter, 0);
  const std::string digest = filter.digest();
  GridSlam slam(on_cpu(GridSlamConfig()));
  Localizer localizer(on_cpu(LocalizerConfig()), room);
  localizer.start_at(start, 0.1, 0.1, 0.05);
  const std::vector<std::pair<std::string, double Scan::*>> numbers = {
      {"stamp_s", &Scan::stamp_s},
      {"angle_min_rad", &Scan::angle_min_rad},
      {"angle_step_rad", &Scan::angle_step_rad},
      {"range_min_m", &Scan::range_min_m},
      {"range_max_m", &Scan::range_max_m},
      {"scan_time_s", &Scan::scan_time_s}};
  const auto expect_refused = [&](const Scan& bad, const std::string& name) {
    for (const std::string& text :
         {error_of([&] { filter.step(drive.scans[1].odometry, bad); }), error_of([&] { slam.step({}, bad); }),
          error_of([&] { localizer.step(drive.scans[1].odometry, bad); })})
      expect_parts(text, {"scan robotlaser1: expected a", name, "finite"});
  };
  for (const auto& [name, number] : numbers)
    for (const double value : {kNan, kInfinity, -kInfinity}) {
      Scan bad = drive.scans[1].scan;
      bad.*number = value;
      expect_refused(bad, name);
    }
  Scan bad = drive.scans[1].scan;
  bad.T_base_sensor.theta_rad = kNan;
  expect_refused(bad, "T_base_sensor.theta_rad");
  EXPECT_EQ(filter.digest(), digest);
  EXPECT_EQ(filter.steps(), 1u);
  ParticleFilter other = started(small_filter());
  step(other, 0);
  EXPECT_EQ(step(filter, 1).pose.x_m, step(other, 1).pose.x_m);  // as if nothing had been
}

TEST_F(Live, AMountOfTheConfigurationThatIsNoNumberIsRefused) {
  FilterConfig config = small_filter();
  config.lidars = {{.name = "front", .x = kNan}};
  expect_parts(error_of([&] { ParticleFilter(config, room); }, ErrorKind::config), {"lidars.front.x", "nan"});
}

TEST_F(Live, GuessesLieOnTheMap) {
  ParticleFilter filter(small_filter(), room);
  const std::vector<PoseGuess> guesses = {{start, 0.1, 0.1}, {{50.0, 1.0, 0.0}, 0.1, 0.1}};
  expect_parts(error_of([&] { filter.start_at(guesses); }), {"(50.0", "inside the map"});
  Localizer localizer(on_cpu(LocalizerConfig()), room);
  error_of([&] { localizer.start_at(guesses); });
}

TEST_F(Live, AStepBeforeAStartSaysWhatToCall) {
  ParticleFilter filter(small_filter(), room);
  FlowFilter flow(FlowMethod::ekf, on_cpu(FlowFilterConfig()), room);
  Localizer localizer(on_cpu(LocalizerConfig()), room);
  const Scan& scan = drive.scans[0].scan;
  for (const std::string& text : {error_of([&] { filter.step({}, scan); }, ErrorKind::usage),
                                  error_of([&] { filter.step(scan); }, ErrorKind::usage),
                                  error_of([&] { flow.step({}, scan); }, ErrorKind::usage),
                                  error_of([&] { localizer.step({}, scan); }, ErrorKind::usage)})
    expect_parts(text, {"call start_at or start_anywhere first"});
  error_of([&] { (void)filter.predict(0.0); }, ErrorKind::usage);
  error_of([&] { (void)localizer.predict(0.0); }, ErrorKind::usage);
}

TEST_F(Live, AMisspeltLidarIsToldOnce) {
  FilterConfig config = small_filter();
  std::vector<std::string> told;
  config.on_warning = [&](const std::string& text) { told.push_back(text); };
  config.lidars = {{.name = "robotlaser2"}, {.name = "rear"}};
  ParticleFilter filter = started(config);
  for (std::size_t k = 0; k < 5; ++k) step(filter, k);
  ASSERT_EQ(told.size(), 1u);
  expect_parts(told[0], {"'robotlaser1'", "is it 'robotlaser2'"});

  told.clear();
  config.lidars = {{.name = "robotlaser1"}, {.name = "rear"}};
  ParticleFilter right = started(config);
  step(right, 0);
  EXPECT_TRUE(told.empty());
  right.step({kNan, 0.0, 0.0}, drive.scans[1].scan);
  right.step({kNan, 0.0, 0.0}, drive.scans[2].scan);
  right.step({100.0, 0.0, 0.0}, drive.scans[3].scan);
  ASSERT_EQ(told.size(), 2u);
  expect_parts(told[0], {"not finite"});
  expect_parts(told[1], {"jumps"});
}

TEST_F(Live, ScansThatComeTwiceOrFarTooLateAreRefusedInWords) {
  FilterConfig config = small_filter();
  config.scan.check_stamps = true;
  ParticleFilter filter = started(config);
  for (std::size_t k = 0; k < 10; ++k) EXPECT_TRUE(step(filter, k).weighted);
  const std::string digest = filter.digest();
  EXPECT_FALSE(step(filter, 9).weighted);
  EXPECT_EQ(filter.why_skipped(), "a scan of this LiDAR with this stamp was taken already");
  Scan old = drive.scans[0].scan;
  old.stamp_s -= 3.0;
  EXPECT_FALSE(filter.step(drive.scans[0].odometry, old).weighted);
  expect_parts(filter.why_skipped(), {"3.9 s older", "2 s"});
  EXPECT_EQ(filter.digest(), digest);
  old.sensor = "another";  // has no newer one
  EXPECT_TRUE(filter.step(drive.scans[9].odometry, old).weighted);
}

// One that comes after the next is weighed where the robot was at its stamp, by the readings in between.
TEST_F(Live, ALateScanIsWeighedWhereItWasTaken) {
  FilterConfig config = small_filter();
  config.scan.check_stamps = true;
  ParticleFilter filter = started(config);
  for (std::size_t k = 0; k < 10; ++k) filter.add_odometry(drive.scans[k].stamp_s, drive.scans[k].odometry);
  for (const std::size_t k : {0, 1, 2, 3, 4, 6, 7, 8}) EXPECT_TRUE(filter.step(drive.scans[k].scan).weighted);
  const Estimate late = filter.step(drive.scans[5].scan);
  EXPECT_TRUE(late.weighted);
  EXPECT_EQ(late.stamp_s, drive.scans[5].scan.stamp_s);
  EXPECT_LT(distance_m(late.pose, drive.truth[5].pose), 0.1);
  const Estimate next = filter.step(drive.scans[9].scan);
  EXPECT_TRUE(next.weighted);
  EXPECT_LT(distance_m(next.pose, drive.truth[9].pose), 0.1);
  EXPECT_EQ(filter.odometry_jumps(), 0u);
}

TEST_F(Live, AClockThatWasSetBackIsFollowed) {
  FilterConfig config = small_filter();
  config.scan.check_stamps = true;
  ParticleFilter filter = started(config);
  for (std::size_t k = 0; k < 10; ++k) step(filter, k);
  std::size_t weighted = 0;
  for (std::size_t k = 10; k < 20; ++k) {
    Scan scan = drive.scans[k].scan;
    scan.stamp_s -= 60.0;
    weighted += filter.step(drive.scans[k].odometry, scan).weighted ? 1 : 0;
  }
  EXPECT_EQ(weighted, 8u);  // the third in a row and all after it
}

// The readings say where the robot was at a scan; where they do not reach, nothing is guessed.
TEST_F(Live, OdometryIsLookedUpAtTheScan) {
  ParticleFilter given = started(small_filter()), looked_up = started(small_filter());
  EXPECT_FALSE(looked_up.step(drive.scans[0].scan).weighted);
  EXPECT_EQ(looked_up.why_skipped(), "no odometry reading was added");
  for (std::size_t k = 0; k < 10; ++k) {
    const LogRecord& r = drive.scans[k];
    looked_up.add_odometry(r.stamp_s, r.odometry);
    EXPECT_EQ(looked_up.step(r.scan).pose.x_m, given.step(r.odometry, r.scan).pose.x_m);
  }
  Scan future = drive.scans[19].scan;
  future.stamp_s += 1.0;
  EXPECT_FALSE(looked_up.step(future).weighted);
  expect_parts(looked_up.why_skipped(), {"from 100.000 to 100.900 s", "102.900 s"});
  EXPECT_EQ(looked_up.steps(), 10u);
}

// A scan that was too early for its odometry may be given again.
TEST_F(Live, AScanWaitsForItsOdometry) {
  FilterConfig config = small_filter();
  config.scan.check_stamps = true;
  ParticleFilter filter = started(config);
  filter.add_odometry(drive.scans[0].stamp_s, drive.scans[0].odometry);
  EXPECT_TRUE(filter.step(drive.scans[0].scan).weighted);
  EXPECT_FALSE(filter.step(drive.scans[8].scan).weighted);
  for (std::size_t k = 1; k < 9; ++k) filter.add_odometry(drive.scans[k].stamp_s, drive.scans[k].odometry);
  EXPECT_TRUE(filter.step(drive.scans[8].scan).weighted);
  EXPECT_FALSE(filter.step(drive.scans[8].scan).weighted);
}

TEST_F(Live, SlamLooksItUpToo) {
  GridSlamConfig config = on_cpu(GridSlamConfig());
  config.slam.particles = 3;
  config.scan.check_stamps = true;
  GridSlam given(config), looked_up(config);
  EXPECT_FALSE(looked_up.step(drive.scans[0].scan));
  for (const LogRecord& r : drive.scans) {
    looked_up.add_odometry(r.stamp_s, r.odometry);
    EXPECT_EQ(looked_up.step(r.scan), given.step(r.odometry, r.scan));
    EXPECT_FALSE(looked_up.step(r.scan));  // twice
  }
  EXPECT_GT(given.records().size(), 3u);
  EXPECT_EQ(given.digest(), looked_up.digest());
}

}  // namespace
}  // namespace parloc
