// What a robot asks of a filter besides steps: starts with a whole covariance, poses between scans, another
// map, and an operator's word in the middle of a run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "common/filter/particle_filter.h"
#include "common/filter/pose/gaussian.h"
#include "common/flow/flow_filter.h"
#include "common/localize/localizer.h"
#include "tests/unit/expect.h"
#include "tests/unit/live_drive.h"
#include "tests/unit/localize_scenes.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

FilterConfig live_config(std::int64_t particles = 300) {
  FilterConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = 1;
  c.particles = particles;
  return c;
}

class LiveFilter : public LiveDrive {};

TEST_F(LiveFilter, ADiagonalCovarianceStartsWithTheBitsOfItsDeviations) {
  ParticleFilter by_sigmas(live_config(), room), by_covariance(live_config(), room);
  by_sigmas.start_at(start, 0.3, 0.1, 0.07);
  by_covariance.start_at(start, Covariance{{0.3 * 0.3, 0, 0, 0, 0.1 * 0.1, 0, 0, 0, 0.07 * 0.07}});
  EXPECT_EQ(by_sigmas.digest(), by_covariance.digest());
}

TEST_F(LiveFilter, AWholeCovarianceIsDrawn) {
  const Covariance asked{{0.09, 0.05, 0.01, 0.05, 0.04, -0.004, 0.01, -0.004, 0.01}};
  ParticleFilter filter(live_config(20000), room);
  filter.start_at({3.0, 2.0, 0.5}, asked);
  double n = 0.0, c[9] = {};
  for (const Particle& p : filter.particles()) {
    const double e[3] = {p.x_m - 3.0, p.y_m - 2.0, p.theta_rad - 0.5};
    for (int i = 0; i < 9; ++i) c[i] += e[i / 3] * e[i % 3];
    ++n;
  }
  for (int i = 0; i < 9; ++i) {  // within 5 standard errors of a sample covariance
    const double tolerance = 5.0 * std::sqrt(2.0 * asked.v[i / 3 * 4] * asked.v[i % 3 * 4] / n);
    EXPECT_NEAR(c[i] / n, asked.v[i], tolerance) << i;
  }
}

TEST_F(LiveFilter, ACovarianceThatIsNoneIsRefused) {
  ParticleFilter filter(live_config(), room);
  FlowFilterConfig flow;
  flow.backend = BackendChoice::cpu;
  FlowFilter ekf(FlowMethod::ekf, flow, room);
  const std::vector<std::pair<Covariance, std::string>> bad = {
      {{{0.1, 0.02, 0, 0.01, 0.1, 0, 0, 0, 0.1}}, "symmetric"},
      {{{0.1, 0.2, 0, 0.2, 0.1, 0, 0, 0, 0.1}}, "positive semidefinite"},
      {{{0.0, 0.1, 0, 0.1, 0.1, 0, 0, 0, 0.1}}, "positive semidefinite"},
      {{{-0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1}}, "not negative"},
      {{{0.1, 0, 0, 0, NAN, 0, 0, 0, 0.1}}, "finite"}};
  for (const auto& [covariance, part] : bad) {
    expect_parts(error_of([&] { filter.start_at(start, covariance); }), {"covariance of a pose", part});
    expect_parts(error_of([&] { ekf.start_at(start, covariance); }), {part});
  }
  filter.start_at(start, Covariance{{0.04, 0.02, 0, 0.02, 0.01, 0, 0, 0, 0}});  // a line, and no turn
  ekf.start_at(start, Covariance{});
}

TEST(Covariance, IsReadFromAndWrittenForRos) {
  double ros[36];
  for (int i = 0; i < 36; ++i) ros[i] = i;
  const Covariance c = covariance_from_ros(ros);
  const double expected[9] = {0, 1, 5, 6, 7, 11, 30, 31, 35};
  for (int i = 0; i < 9; ++i) EXPECT_EQ(c.v[i], expected[i]);
  const std::array<double, 36> back = ros_covariance(c);
  double sum = 0.0;
  for (const double v : back) sum += v;
  EXPECT_EQ(sum, 0 + 1 + 5 + 6 + 7 + 11 + 30 + 31 + 35);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(covariance_from_ros(back).v[i], expected[i]);
}

// Propagated by formula as by particles: one step of the motion model without a scan.
TEST_F(LiveFilter, APredictionIsWhatTheParticlesBecome) {
  for (const MotionForm form : {MotionForm::seed, MotionForm::thrun, MotionForm::omni}) {
    FilterConfig config = live_config(50000);
    config.motion.form = form;
    config.motion.slip_share = 0.1;
    ParticleFilter filter(config, room);
    filter.start_at({3.0, 2.0, 0.3}, Covariance{{0.01, 0.004, 0.001, 0.004, 0.01, 0, 0.001, 0, 0.004}});
    Scan none;
    none.stamp_s = 10.0;
    filter.step({1.0, 1.0, -0.2}, none);
    const Pose later = compose({1.0, 1.0, -0.2}, {0.4, 0.03, 0.1});
    filter.add_odometry(10.4, later);
    const PoseEstimate said = filter.predict(10.4);
    none.stamp_s = 10.4;
    const Estimate moved = filter.step(later, none);
    expect_near(said.mean, moved.mean.mean, 0.01, 0.01);
    for (int i = 0; i < 9; ++i) {
      const double scale = std::sqrt(moved.mean.covariance.v[i / 3 * 4] * moved.mean.covariance.v[i % 3 * 4]);
      EXPECT_NEAR(said.covariance.v[i], moved.mean.covariance.v[i], 0.05 * scale) << i;
    }
  }
}

TEST_F(LiveFilter, PredictsBetweenScansByTheReadings) {
  ParticleFilter filter = started(live_config());
  Estimate e;
  for (std::size_t k = 0; k < 10; ++k) {
    filter.add_odometry(drive.scans[k].stamp_s, drive.scans[k].odometry);
    e = step(filter, k);
  }
  EXPECT_EQ(e.stamp_s, drive.scans[9].stamp_s);
  const PoseEstimate now = filter.predict(e.stamp_s);
  expect_equal(now.mean, e.pose);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(now.covariance.v[i], e.covariance.v[i]);
  // The drive is an arc at constant speed: with what is known, a little ahead, and back.
  expect_near(filter.predict(e.stamp_s + 0.05).mean,
              compose(e.pose, along_arc(relative(drive.truth[10].pose, drive.truth[9].pose), 0.5)), 1e-6,
              1e-6);
  filter.add_odometry(drive.scans[10].stamp_s, drive.scans[10].odometry);
  expect_near(filter.predict(drive.scans[10].stamp_s).mean,
              compose(e.pose, relative(drive.truth[10].pose, drive.truth[9].pose)), 1e-9, 1e-9);
  expect_near(filter.predict(drive.scans[5].stamp_s).mean,
              compose(e.pose, relative(drive.truth[5].pose, drive.truth[9].pose)), 1e-9, 1e-9);
  EXPECT_GT(filter.predict(drive.scans[10].stamp_s).covariance.v[8], e.covariance.v[8]);
  expect_parts(error_of([&] { (void)filter.predict(e.stamp_s + 10.0); }), {"within 2 s"});
  error_of([&] { (void)filter.predict(NAN); });
}

/// The same walls, drawn from another corner and turned; of another resolution is another drawing.
GridMap redrawn(const GridMap& map, const Pose& T_map_grid) {
  GridMap other = map;
  other.T_map_grid = T_map_grid;
  const Pose corner = T_map_grid;
  other.width += 20, other.height += 20;
  other.cells.assign(static_cast<std::size_t>(other.width) * static_cast<std::size_t>(other.height),
                     Cell::unknown);
  for (std::int32_t j = 0; j < other.height; ++j)
    for (std::int32_t i = 0; i < other.width; ++i) {
      const Pose centre = compose(corner, {(i + 0.5) * map.resolution_m, (j + 0.5) * map.resolution_m, 0.0});
      other.cells[other.index(i, j)] = map.at_point(centre.x_m, centre.y_m);
    }
  return other;
}

TEST_F(LiveFilter, TheSameMapAgainChangesNoBit) {
  ParticleFilter one = started(live_config()), other = started(live_config());
  for (std::size_t k = 0; k < 20; ++k) {
    if (k == 10) other.replace_map(room);
    const Estimate a = step(one, k), b = step(other, k);
    ASSERT_EQ(a.pose.x_m, b.pose.x_m) << k;
  }
  EXPECT_EQ(one.digest(), other.digest());
}

TEST_F(LiveFilter, AMapInAnotherGridFrameKeepsThePose) {
  for (const SensorModel model : {SensorModel::beam, SensorModel::likelihood_field}) {
    FilterConfig config = live_config(1000);
    config.sensor = default_sensor(model);
    ParticleFilter filter = started(config);
    Estimate e;
    for (std::size_t k = 0; k < 10; ++k) e = step(filter, k);
    ParticleFilter::PreparedMap next = filter.prepare_map(redrawn(room, {-0.7, -0.9, 0.0}));
    EXPECT_EQ(next.map().width, room.width + 20);
    filter.replace_map(std::move(next));
    EXPECT_EQ(filter.map().width, room.width + 20);
    EXPECT_EQ(filter.steps(), 10u);
    for (std::size_t k = 10; k < 20; ++k) e = step(filter, k);
    EXPECT_LT(distance_m(e.pose, drive.truth.back().pose), 0.1);
    EXPECT_FALSE(e.lost);
    filter.replace_map(redrawn(room, {1.0, -2.0, 0.5}));  // turned: a part of the room is off this grid
    EXPECT_LT(distance_m(filter.predict(e.stamp_s).mean, e.pose), 1e-12);
  }
}

TEST_F(LiveFilter, APreparedMapBelongsToItsFilter) {
  ParticleFilter one = started(live_config()), other = started(live_config());
  error_of([&] { one.replace_map(other.prepare_map(room)); }, ErrorKind::usage);
  ParticleFilter::PreparedMap once = one.prepare_map(room);
  one.replace_map(std::move(once));
  error_of([&] { one.replace_map(std::move(once)); }, ErrorKind::usage);
  GridMap none = room;
  none.cells.clear();
  error_of([&] { (void)one.prepare_map(none); });
}

TEST_F(LiveFilter, AnOperatorSaysWhereItIs) {
  ParticleFilter filter = started(live_config(1000));
  error_of([&] { ParticleFilter(live_config(), room).relocate(start, Covariance{}); }, ErrorKind::usage);
  for (std::size_t k = 0; k < 5; ++k) step(filter, k);
  filter.relocate({{{5.5, 3.5, 0.0}, 0.1, 0.1}});  // wrong
  step(filter, 5);
  filter.relocate(drive.truth[5].pose, covariance_of(0.1, 0.1, 0.05));
  expect_equal(filter.predict(drive.scans[5].stamp_s).mean, drive.truth[5].pose);
  Estimate e;
  for (std::size_t k = 6; k < 20; ++k) e = step(filter, k);
  EXPECT_LT(distance_m(e.pose, drive.truth.back().pose), 0.1);
  EXPECT_EQ(filter.steps(), 20u);
  error_of([&] { filter.relocate({99.0, 0.0, 0.0}, Covariance{}); });
}

// ---- the closed loop
// --------------------------------------------------------------------------------------------------

class LiveLocalizer : public testing::Test {
 protected:
  const GridMap map = test::two_rooms();
  const TrialLog log = test::drive(map, TrialTask::track, 8.0, 7);
  const Pose start = log.truth.front().pose;

  Localizer started() const {
    Localizer localizer(test::small_localizer(), map);
    localizer.start_at(start, 0.2, 0.2, 0.1);
    return localizer;
  }
  /// Feeds the records of a part of the log; the last that it says.
  LocalizerEstimate feed(Localizer& localizer, double from, double to) const {
    const auto at = [&](double share) {
      return log.records.begin() +
             static_cast<std::ptrdiff_t>(share * static_cast<double>(log.records.size()));
    };
    return test::feed(localizer, {at(from), at(to)}).back();
  }
};

TEST_F(LiveLocalizer, KeepsPoseAndStateOverANewMap) {
  Localizer localizer = started();
  feed(localizer, 0.0, 0.5);
  std::optional<Localizer::PreparedMap> next;
  std::thread beside([&] { next = localizer.prepare_map(redrawn(map, {-0.55, -0.75, 0.0})); });
  LocalizerEstimate e = feed(localizer, 0.5, 0.6);  // while tables are made
  beside.join();
  ASSERT_EQ(e.health.state, HealthState::tracking);
  const double before = e.health.log_odds;
  localizer.replace_map(std::move(*next));
  EXPECT_EQ(localizer.filter().map().width, map.width + 20);
  e = feed(localizer, 0.6, 0.7);
  EXPECT_EQ(e.health.state, HealthState::tracking);
  EXPECT_GE(e.health.log_odds, 0.9 * before);
  EXPECT_EQ(localizer.searches(), 0u);
  e = feed(localizer, 0.7, 1.0);
  EXPECT_LT(distance_m(e.filter.pose, log.truth.back().pose), 0.2);
  Localizer other = started();
  error_of([&] { localizer.replace_map(other.prepare_map(map)); }, ErrorKind::usage);
}

TEST_F(LiveLocalizer, TheSameMapAgainChangesNoBit) {
  Localizer one = started(), other = started();
  feed(one, 0.0, 0.5), feed(other, 0.0, 0.5);
  other.replace_map(map);
  const LocalizerEstimate a = feed(one, 0.5, 1.0), b = feed(other, 0.5, 1.0);
  EXPECT_EQ(a.filter.pose.x_m, b.filter.pose.x_m);
  EXPECT_EQ(a.health.log_odds, b.health.log_odds);
  EXPECT_EQ(one.filter().digest(), other.filter().digest());
}

TEST_F(LiveLocalizer, AnOperatorIsBelieved) {
  Localizer localizer(test::small_localizer(), map);
  localizer.start_at({12.5, 8.0, 1.0}, 0.1, 0.1, 0.1);  // wrong
  feed(localizer, 0.0, 0.3);
  const auto scans = static_cast<std::size_t>(0.3 * static_cast<double>(log.truth.size()));
  const double now_s = localizer.filter().steps() > 0 ? log.truth[scans].stamp_s : 0.0;
  Pose here = log.truth[scans].pose;
  for (const StampedPose& p : log.truth)
    if (p.stamp_s <= now_s) here = p.pose;
  localizer.relocate(here, covariance_of(0.3, 0.3, 0.2));
  const LocalizerEstimate e = feed(localizer, 0.3, 1.0);
  EXPECT_EQ(e.health.state, HealthState::tracking);
  EXPECT_LT(distance_m(e.filter.pose, log.truth.back().pose), 0.2);
}

// No step is to do more than a slice, whatever else it takes; the robot may stand until it is found.
TEST_F(LiveLocalizer, FindsItsStartInSlices) {
  LocalizerConfig config = test::small_localizer();
  config.localize.first_search_at_once = false;
  config.localize.search_slice = 1.0;
  config.update_min_d = config.update_min_a = 0.2;
  Localizer localizer(config, map);
  localizer.start_anywhere();
  const LogRecord& first = *std::find_if(log.records.begin(), log.records.end(),
                                         [](const LogRecord& r) { return r.kind == RecordKind::scan; });
  std::size_t scans = 0;
  LocalizerEstimate e;
  for (Scan scan = first.scan; localizer.searches() == 0 && scans < 1000; ++scans, scan.stamp_s += 0.2) {
    e = localizer.step(first.odometry, scan);
    EXPECT_TRUE(e.searched || e.health.state == HealthState::lost);
  }
  EXPECT_GT(scans, 5u);
  EXPECT_LT(scans, 1000u);
  EXPECT_TRUE(e.searched);
  EXPECT_LT(distance_m(e.filter.pose, start), 0.2);
}

TEST_F(LiveLocalizer, PredictsWithTheCovarianceOfTheClosedLoop) {
  Localizer localizer = started();
  const LocalizerEstimate e = feed(localizer, 0.0, 1.0);
  const PoseEstimate now = localizer.predict(e.filter.stamp_s),
                     later = localizer.predict(e.filter.stamp_s + 0.1);
  expect_equal(now.mean, e.filter.pose);
  EXPECT_EQ(now.covariance.v[0], e.filter.covariance.v[0]);
  EXPECT_GT(later.covariance.v[8], now.covariance.v[8]);
}

}  // namespace
}  // namespace parloc
