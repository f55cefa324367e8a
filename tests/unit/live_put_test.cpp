// Another map and other settings for a localizer that is fed with messages: what stays, and what begins anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/error.h"
#include "tests/unit/live_scene.h"

namespace parloc {
namespace {

/// The same walls in a grid that begins elsewhere and is larger by so many cells on every side.
GridMap in_larger_grid(const GridMap& map, int margin) {
  GridMap out = map;
  out.width += 2 * margin, out.height += 2 * margin;
  out.cells.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height), Cell::unknown);
  for (int y = 0; y < map.height; ++y)
    std::copy_n(map.cells.begin() + static_cast<std::ptrdiff_t>(y) * map.width, map.width,
                out.cells.begin() + static_cast<std::ptrdiff_t>(y + margin) * out.width + margin);
  const double margin_m = margin * map.resolution_m;
  out.T_map_grid = compose(map.T_map_grid, Pose{-margin_m, -margin_m, 0.0});
  return out;
}

/// Two robots with the same messages; to the second something is done at half.
struct Twins {
  Scene scene = hall_scene();
  std::ptrdiff_t half = static_cast<std::ptrdiff_t>(scene.messages.size() / 2);
  LiveLocalizer one = robot_of(scene), other = robot_of(scene);
  std::vector<LiveAnswer> by_one, by_other;

  Twins() {
    one.start(about(hall_drive().truth.front().pose));
    other.start(about(hall_drive().truth.front().pose));
    feed_both(scene.messages.begin(), scene.messages.begin() + half);
  }
  void drive_on() { feed_both(scene.messages.begin() + half, scene.messages.end()); }
  void expect_all_answered() const {
    ASSERT_EQ(by_one.size(), by_other.size());
    for (std::size_t k = 0; k < by_one.size(); ++k) EXPECT_EQ(by_one[k].stamp_s, by_other[k].stamp_s);
  }

 private:
  void feed_both(std::vector<Message>::const_iterator from, std::vector<Message>::const_iterator to) {
    by_one = feed(one, {from, to});
    by_other = feed(other, {from, to});
  }
};

TEST(LivePut, TheSameMapAgainChangesNoBit) {
  Twins twins;
  std::optional<PreparedLocalizer> next;
  std::thread beside([&] { next = twins.other.prepare(twins.scene.config, twins.scene.map); });
  beside.join();
  twins.other.put(std::move(*next));
  twins.drive_on();
  twins.expect_all_answered();
  EXPECT_EQ(twins.one.localizer().filter().digest(), twins.other.localizer().filter().digest());
  EXPECT_THROW(twins.other.put(std::move(*next)), Error);  // NOLINT(bugprone-use-after-move): it is used up
}

TEST(LivePut, GoesOnInALargerGridThatBeginsElsewhere) {
  Twins twins;
  twins.other.put(twins.other.prepare(twins.scene.config, in_larger_grid(twins.scene.map, 30)));
  const auto steps = twins.other.localizer().filter().steps();
  EXPECT_EQ(steps, twins.one.localizer().filter().steps());
  twins.drive_on();
  twins.expect_all_answered();
  EXPECT_EQ(twins.other.localizer().filter().map().width, twins.scene.map.width + 60);
  for (std::size_t k = 0; k < twins.by_one.size(); ++k)
    expect_near(twins.by_other[k].estimate.filter.pose, twins.by_one[k].estimate.filter.pose, 0.05, 0.02);
}

TEST(LivePut, OtherSettingsBeginWhereTheRobotIs) {
  Twins twins;
  const LiveAnswer before = twins.by_other.back();
  Config other = twins.scene.config;
  other.particles = 2000;
  twins.other.put(twins.other.prepare(other, twins.scene.map));
  twins.drive_on();
  twins.expect_all_answered();
  EXPECT_EQ(twins.by_other.front().estimate.filter.particles, 2000u);
  const Pose moved = relative(twins.by_other.front().odometry, before.odometry);
  expect_near(twins.by_other.front().estimate.filter.pose, compose(before.estimate.filter.pose, moved), 0.1,
              0.05);
  const double* was = before.estimate.filter.covariance.v;
  const double* is = twins.by_other.front().estimate.filter.covariance.v;
  for (const int k : {0, 4, 8}) EXPECT_LT(is[k], 4.0 * was[k]);
  expect_near(twins.by_other.back().estimate.filter.pose, hall_drive().truth.back().pose, 0.3, 0.2);
}

TEST(LivePut, OtherSettingsKeepThePlacesThatArePossible) {
  const GridMap map = corridor();  // which looks the same from its other end
  const SimulatedLog log = simulate(spin(), map);
  Scene scene(log, map);
  LiveLocalizer robot = robot_of(scene);
  robot.start({});
  std::vector<LiveAnswer> before;
  auto at = scene.messages.begin();
  for (; before.size() < 6; ++at)
    for (const LiveAnswer& answer : feed(robot, {*at})) before.push_back(answer);
  ASSERT_EQ(before.back().estimate.health.state, HealthState::ambiguous);
  ASSERT_GE(before.back().estimate.modes.size(), 5u);
  scene.config.particles = 700;
  robot.put(robot.prepare(scene.config, map));
  const LocalizerEstimate after = feed(robot, {at, scene.messages.end()}).front().estimate;
  EXPECT_FALSE(after.searched);
  EXPECT_EQ(after.health.state, HealthState::ambiguous);
  EXPECT_GE(after.modes.size(), 3u);
  for (const Mode& mode : after.modes) {
    double nearest_m = 1e9;
    for (const Mode& known : before.back().estimate.modes)
      nearest_m = std::min(nearest_m, distance_m(mode.pose, known.pose));
    EXPECT_LT(nearest_m, 0.5);
  }
}

}  // namespace
}  // namespace parloc
