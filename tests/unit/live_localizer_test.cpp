// A localizer that is fed with messages: it says what `parloc run` says of a bag of them, whatever comes.
#include "common/live/live_localizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "common/inputs/bag_log.h"
#include "common/io/scan_stream.h"
#include "common/live/answer_messages.h"
#include "common/live/live_slam.h"
#include "common/ros/message_writer.h"
#include "common/ros/messages.h"
#include "tests/unit/live_scene.h"

namespace parloc {
namespace {

/// As `parloc run` drives it.
std::string digest_of_bag(const Scene& scene, const Pose& start, std::size_t& scans_answered) {
  const auto log = open_bag_log(scene.bag.path(), log_choice(scene.config));
  ScanStream scans(*log, scene.config.scan, scene.config.lidars, [](std::size_t) {});
  Localizer localizer(scene.config, scene.map);
  localizer.start_at(start, 0.2, 0.2, 0.1);
  scans_answered = 0;
  for (LogRecord record; scans.next(record); ++scans_answered) {
    scans.pass_odometry([&](const StampedPose& r) { localizer.add_odometry(r.stamp_s, r.pose); });
    localizer.step(record.odometry, record.scan);
  }
  return localizer.filter().digest();
}

TEST(LiveLocalizer, SaysWhatIsSaidOfABag) {
  const Scene scene = hall_scene();
  const Pose start = hall_drive().truth.front().pose;
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(start));
  const std::vector<LiveAnswer> answers = feed(robot, scene.messages);
  std::size_t scans = 0;
  EXPECT_EQ(robot.localizer().filter().digest(), digest_of_bag(scene, start, scans));
  EXPECT_GT(scans, 100u);
  EXPECT_EQ(answers.size() + robot.waiting(), scans);
  EXPECT_LE(robot.waiting(), 1u);  // the last one: no odometry comes after it
  EXPECT_TRUE(robot.troubles().empty());
  const Pose truth = hall_drive().truth[answers.size() - 1].pose;
  EXPECT_LT(distance_m(answers.back().estimate.filter.pose, truth), 0.2);
}

TEST(LiveLocalizer, TheTransformTakesOdometryToTheMap) {
  const Scene scene = hall_scene();
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(hall_drive().truth.front().pose));
  for (const LiveAnswer& answer : feed(robot, scene.messages)) {
    const Pose there = compose(answer.T_map_odom, answer.odometry);
    expect_near(there, answer.estimate.filter.pose, 1e-9, 1e-9);
  }
}

TEST(LiveLocalizer, ScansThatTakeTimeAreAnsweredBeforeTheNext) {
  const GridMap map = corridor();
  const SimulatedLog log = simulate(spin(), map);
  const Scene scene(log, map);
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(log.truth.front().pose));
  std::size_t scans = 0, answers = 0;
  for (const Message& message : scene.messages) {
    if (message.role == TopicRole::scan) {
      EXPECT_GE(answers + 1, scans);
      ++scans;
    }
    robot.take(message.role, message.topic, message.bytes);
    while (robot.next()) ++answers;
  }
  EXPECT_GT(scans, 20u);
  EXPECT_GE(answers + 1, scans);
}

TEST(LiveLocalizer, SaysNothingBeforeItIsStarted) {
  const Scene scene = hall_scene();
  LiveLocalizer robot = robot_of(scene);
  EXPECT_TRUE(feed(robot, {scene.messages.begin(), scene.messages.begin() + 200}).empty());
  EXPECT_EQ(robot.localizer().filter().steps(), 0u);
}

TEST(LiveLocalizer, FindsItselfWithoutAPose) {
  const Scene scene = hall_scene();
  LiveLocalizer robot = robot_of(scene);
  robot.start({});
  const std::vector<LiveAnswer> answers = feed(robot, scene.messages);
  const Pose truth = hall_drive().truth[answers.size() - 1].pose;
  EXPECT_LT(distance_m(answers.back().estimate.filter.pose, truth), 0.3);
}

TEST(LiveLocalizer, KeepsItsPoseOnAnotherMap) {
  const Scene scene = hall_scene();
  LiveLocalizer robot(scene.config, has_odometry(scene.messages));
  robot.start(about(hall_drive().truth.front().pose));  // remembered until there is a map
  EXPECT_TRUE(feed(robot, {scene.messages.begin(), scene.messages.begin() + 50}).empty());
  EXPECT_FALSE(robot.started());
  robot.put(robot.prepare(scene.config, scene.map));
  EXPECT_TRUE(robot.started());
  std::size_t answers = 0;
  LiveAnswer last;
  for (std::size_t k = 50; k < scene.messages.size(); ++k) {
    if (k == scene.messages.size() / 2) robot.put(robot.prepare(scene.config, scene.map));
    robot.take(scene.messages[k].role, scene.messages[k].topic, scene.messages[k].bytes);
    for (; auto answer = robot.next(); ++answers) last = *answer;
  }
  EXPECT_LT(distance_m(last.estimate.filter.pose, hall_drive().truth.back().pose), 0.3);
  EXPECT_GT(answers, 100u);
}

TEST(LiveLocalizer, GoesOnWhenTheClockWasSet) {
  const Scene scene = hall_scene();
  const std::size_t half = scene.messages.size() / 2;
  const std::vector<Message> first(scene.messages.begin(),
                                   scene.messages.begin() + static_cast<std::ptrdiff_t>(half));
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(hall_drive().truth.front().pose));
  const std::vector<LiveAnswer> before = feed(robot, first);
  robot.start(about(hall_drive().truth.front().pose));  // the bag begins anew, and so does the robot
  robot.forget();
  const std::vector<LiveAnswer> again = feed(robot, first);
  EXPECT_GE(again.size() + 2, before.size());
  EXPECT_LT(distance_m(again.back().estimate.filter.pose, before.back().estimate.filter.pose), 0.2);
}

/// A message as faults of all kinds leave it.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto any = [&](std::size_t below) { return static_cast<std::size_t>(random()) % below; };
  switch (any(4)) {
    case 0:
      bytes.resize(any(bytes.size()));
      break;
    case 1:
      for (int k = 0; k < 8; ++k) bytes[any(bytes.size())] = static_cast<char>(random());
      break;
    case 2:
      for (std::size_t k = 4 + any(16); k < bytes.size(); ++k) bytes[k] = '\xff';  // NaN everywhere
      break;
    default:
      bytes += std::string(any(100), '\0');
  }
  return bytes;
}

TEST(LiveLocalizer, ThousandFaultsCostNoMoreThanTheirMessages) {
  const Scene scene = hall_scene();
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(hall_drive().truth.front().pose));
  std::mt19937 random(7);
  std::size_t faults = 0, told = 0;
  LiveAnswer last;
  for (const Message& message : scene.messages) {
    if (random() % 2 == 0 && message.role != TopicRole::fixed_transforms) {
      ++faults;
      robot.take(message.role, message.topic, damaged(message.bytes, random));
    }
    robot.take(message.role, message.topic, message.bytes);
    while (auto answer = robot.next()) last = *answer;
    told += robot.troubles().size();
  }
  EXPECT_GT(faults, 500u);
  EXPECT_GT(told, 0u);
  EXPECT_LT(told, 200u);
  EXPECT_TRUE(std::isfinite(last.estimate.filter.pose.x_m));
}

TEST(LiveLocalizer, ALidarThatNobodyPlacedHoldsUpNoOther) {
  const Scene scene = hall_scene();
  LiveLocalizer alone = robot_of(scene), robot = robot_of(scene);
  alone.start(about(hall_drive().truth.front().pose));
  robot.start(about(hall_drive().truth.front().pose));
  std::vector<std::string> told;
  for (const Message& message : scene.messages) {
    if (message.role == TopicRole::scan) {
      LaserScanMessage other;
      read_laser_scan(MessageReader(message.bytes, "cdr"), other);
      other.header.frame = "nowhere";
      robot.take(TopicRole::scan, "/other", write_laser_scan(other).bytes());
    }
    ASSERT_EQ(feed(robot, {message}).size(), feed(alone, {message}).size());
    for (const std::string& line : robot.troubles()) told.push_back(line);
  }
  EXPECT_EQ(robot.localizer().filter().digest(), alone.localizer().filter().digest());
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("nowhere"), std::string::npos) << told[0];
}

TEST(LiveSlam, MapsWhatIsMappedOfABag) {
  Scene scene = hall_scene();
  scene.config.slam.particles = 4;
  LiveSlam robot(scene.config, has_odometry(scene.messages));
  EXPECT_FALSE(robot.map_so_far().has_value());
  std::size_t answers = 0, taken_in = 0;
  for (const Message& message : scene.messages) {
    if (answers >= 60) break;
    robot.take(message.role, message.topic, message.bytes);
    for (; const auto answer = robot.next(); ++answers) {
      taken_in += answer->taken_in ? 1 : 0;
      EXPECT_TRUE(std::isfinite(answer->pose.x_m));
    }
  }
  ASSERT_GT(taken_in, 3u);
  const GridSlamConfig config = grid_slam_config(scene.config);
  GridSlam slam(config);
  const auto log = open_bag_log(scene.bag.path(), log_choice(scene.config));
  ScanStream scans(*log, config.scan, config.lidars, [](std::size_t) {});
  LogRecord record;
  for (std::size_t k = 0; k < answers && scans.next(record); ++k) {
    scans.pass_odometry([&](const StampedPose& r) { slam.add_odometry(r.stamp_s, r.pose); });
    slam.step(record.odometry, record.scan);
  }
  EXPECT_EQ(robot.slam().digest_so_far(), slam.digest_so_far());
  EXPECT_GT(robot.map_so_far()->width, 50);
}

TEST(LiveLocalizer, AnswersAreMessages) {
  const Scene scene = hall_scene();
  LiveLocalizer robot = robot_of(scene);
  robot.start(about(hall_drive().truth.front().pose));
  const LiveAnswer answer = feed(robot, scene.messages).back();
  const MessageWriter pose = pose_message(answer, {});
  EXPECT_EQ(read_pose_stamped(MessageReader(pose.bytes(), "cdr")).header.frame, "map");
  const MessageWriter tf = map_odom_message(answer, {}, 0.5);
  const std::vector<TransformMessage> read = read_transforms(MessageReader(tf.bytes(), "cdr"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].child_frame, "odom");
  EXPECT_NEAR(read[0].header.stamp_s, answer.stamp_s + 0.5, 1e-6);
  expect_near(planar(read[0].T_parent_child), answer.T_map_odom, 1e-12, 1e-12);
  EXPECT_GT(particles_message(answer, {}, robot.localizer(), 100).bytes().size(), 100u * 64u);
  EXPECT_GT(diagnostics_message(answer, {}, "parloc").bytes().size(), 50u);
}

}  // namespace
}  // namespace parloc
