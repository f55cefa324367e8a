// What is written as MCAP, read back with the project's own readers.
#include "common/mcap/mcap_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/math/portable64.h"
#include "common/ros/message_definitions.h"
#include "common/ros/message_writer.h"
#include "tests/unit/temp_file.h"

namespace parloc::test {
namespace {

struct ReadMessage {
  std::string topic, bytes;
  std::int64_t stamp_ns;
};

std::vector<ReadMessage> messages_of(BagReader& bag) {
  bag.select(std::vector<bool>(bag.topics().size(), true));
  std::vector<ReadMessage> messages;
  for (BagMessage message; bag.next(message);)
    messages.push_back({bag.topics()[message.topic].name, std::string(message.bytes), message.stamp_ns});
  return messages;
}

/// 300 messages of 20 kB that hardly pack: six chunks.
std::string written(bool finished) {
  std::string bytes;
  McapWriter writer([&](std::string_view part) { bytes += part; });
  const std::uint16_t a = writer.add_topic({"/a", "nav_msgs/msg/Path", "float64 x\n", true});
  const std::uint16_t b = writer.add_topic({"/b", "nav_msgs/msg/Odometry", "float64 y\n"});
  std::mt19937 random(1);
  for (int k = 0; k < 300; ++k) {
    std::string message;
    for (int i = 0; i < 20000; ++i) message += static_cast<char>(random());
    writer.write(k % 3 == 0 ? a : b, 1'000'000'000 + k, message);
  }
  if (finished) writer.finish();
  return bytes;
}

TEST(McapWriter, IsReadBackInOrder) {
  const TempFile file("a.mcap", written(true));
  const auto bag = open_bag(file.path());
  const std::vector<ReadMessage> messages = messages_of(*bag);
  ASSERT_EQ(messages.size(), 300u);
  EXPECT_EQ(bag->faults().count, 0u);
  ASSERT_EQ(bag->topics().size(), 2u);
  EXPECT_EQ(bag->topics()[0].type, "nav_msgs/Path");
  EXPECT_EQ(bag->topics()[1].encoding, "cdr");
  for (std::size_t k = 0; k < messages.size(); ++k) {
    EXPECT_EQ(messages[k].topic, k % 3 == 0 ? "/a" : "/b");
    EXPECT_EQ(messages[k].stamp_ns, 1'000'000'000 + static_cast<std::int64_t>(k));
    EXPECT_EQ(messages[k].bytes.size(), 20000u);
  }
}

TEST(McapWriter, GivesOutEachChunkAndNeedsNoEnd) {
  const TempFile file("cut.mcap", written(false));
  const auto bag = open_bag(file.path());
  const std::size_t read = messages_of(*bag).size();
  EXPECT_GE(read, 240u);  // all but the last chunk's
  EXPECT_LT(read, 300u);
  EXPECT_EQ(bag->faults().count, 1u);  // that it is cut off
}

TEST(McapWriter, ChunksEndByTheClock) {
  std::size_t given = 0;
  McapWriter writer([&](std::string_view part) { given += part.size(); }, 0.0);
  const std::uint16_t topic = writer.add_topic({"/a", "nav_msgs/msg/Path", ""});
  for (int k = 0; k < 3; ++k) {
    const std::size_t before = given;
    writer.write(topic, k, "1234");
    EXPECT_GT(given, before);
  }
}

TEST(McapWriter, SameCallsGiveTheSameBytes) {
  EXPECT_EQ(written(true), written(true));
}

TEST(McapWriter, GrowingFileKeepsWhatWasThereUntilItIsWritten) {
  const TempFile file("grow", "before");
  { const GrowingFile untouched(file.path()); }
  EXPECT_EQ(content_of(file.path()), "before");
  {
    GrowingFile growing(file.path());
    growing.append("a");
    EXPECT_EQ(content_of(file.path()), "a");
    growing.append("b");
  }
  EXPECT_EQ(content_of(file.path()), "ab");
  const std::string fresh = file.path() + "_new";
  { const GrowingFile nothing(fresh); }
  EXPECT_FALSE(std::filesystem::exists(fresh));
}

TEST(MessageWriter, StampsAreReadBackToTheBit) {
  std::mt19937_64 random(2);
  for (const double size_s : {1.0, 100.0, 4e6, 1.2e9, 1.7e9}) {
    std::uniform_real_distribution<double> any(0.0, size_s);
    for (int k = 0; k < 2000; ++k) {
      const double stamp_s = std::round(any(random) * 1e6) / 1e6;  // as text of 6 decimals is read
      const RosTime time = ros_time(stamp_s);
      EXPECT_EQ(seconds_of(time.seconds, time.nanoseconds), stamp_s);
      EXPECT_EQ(time.nanoseconds % 1000, 0u) << stamp_s;
    }
  }
  EXPECT_EQ(ros_time(-0.25).seconds, -1);
  EXPECT_EQ(ros_time(-0.25).nanoseconds, 750'000'000u);
  EXPECT_EQ(ros_time(2.9999999999).seconds, 3);
  EXPECT_EQ(ros_time(2.9999999999).nanoseconds, 0u);
  for (const double bad : {1e11, -1e11, std::nan("")}) EXPECT_THROW(ros_time(bad), Error);
}

TEST(MessageWriter, HeadingsAreReadBack) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-kPi, kPi);
  int exact = 0;
  constexpr int tries = 5000;
  for (int k = 0; k < tries; ++k) {
    const Pose pose{1.0, -2.0, any(random)};
    RigidTransform upright = spatial(pose);
    ASSERT_TRUE(normalise(upright));
    EXPECT_NEAR(planar(upright).theta_rad, pose.theta_rad, 5e-16);
    exact += planar(upright).theta_rad == pose.theta_rad ? 1 : 0;
    RigidTransform hanging = spatial(pose, true);
    ASSERT_TRUE(normalise(hanging));
    const PlanarMount mount = planar_mount(hanging);
    EXPECT_TRUE(mount.upside_down);
    EXPECT_NEAR(turn_rad(mount.T_base_sensor, pose), 0.0, 5e-16);
    EXPECT_LT(mount.tilt_rad, 1e-7);
  }
  EXPECT_GT(exact, tries * 98 / 100);
  for (const double heading_rad : {0.0, -kPi, 0.5 * kPi, -0.5 * kPi, 1e-300}) {
    RigidTransform at = spatial({0.0, 0.0, heading_rad});
    normalise(at);
    EXPECT_EQ(planar(at).theta_rad, wrap64(heading_rad));
  }
}

TEST(MessageWriter, ScansAreReadBack) {
  LaserScanMessage scan{{12.5, "laser"}, -1.5f, 1.5f, 0.5f, 0.001f, 0.0f, 0.1f, 30.0f, {}};
  const float inf = std::numeric_limits<float>::infinity();
  scan.ranges_m = {1.0f, inf, 0.0f, -inf, 2.5f, 81.83f, 7.0f};
  LaserScanMessage read;
  const MessageWriter written = write_laser_scan(scan);
  read_laser_scan(MessageReader(written.bytes(), "cdr"), read);
  EXPECT_EQ(read.header.stamp_s, 12.5);
  EXPECT_EQ(read.header.frame, "laser");
  EXPECT_EQ(read.angle_step_rad, 0.5f);
  EXPECT_EQ(read.time_step_s, 0.001f);
  EXPECT_EQ(read.range_max_m, 30.0f);
  EXPECT_EQ(read.ranges_m, scan.ranges_m);
}

TEST(MessageWriter, PosesAndTransformsAreReadBack) {
  const RigidTransform T = spatial({1.0, 2.0, 0.5});
  const MessageWriter odometry = write_odometry({{3.0, "odom"}, "base_link", T});
  const OdometryMessage o = read_odometry(MessageReader(odometry.bytes(), "cdr"));
  EXPECT_EQ(o.child_frame, "base_link");
  EXPECT_TRUE(o.pose == T);
  const MessageWriter tf = write_transforms({{{3.0, "a"}, "b", T}, {{4.0, "bcd"}, "efghij", T}});
  const std::vector<TransformMessage> read = read_transforms(MessageReader(tf.bytes(), "cdr"));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].child_frame, "efghij");
  EXPECT_EQ(read[1].header.stamp_s, 4.0);
  EXPECT_TRUE(read[1].T_parent_child == T);
  const double covariance[9] = {1, 2, 3, 2, 4, 5, 3, 5, 6};
  const MessageWriter pose = write_pose_with_covariance({5.0, "map"}, {1.0, 2.0, 0.5}, covariance);
  EXPECT_TRUE(read_pose_stamped(MessageReader(pose.bytes(), "cdr")).pose == T);
}

TEST(MessageWriter, GridsAreReadBack) {
  const OccupancyGridMessage grid{{1.0, "map"},           0.25, 3, 2, spatial({-1.0, -2.0, 0.3}),
                                  {0, 100, -1, 0, 0, 100}};
  const MessageWriter written = write_occupancy_grid(grid);
  const OccupancyGridMessage read = read_occupancy_grid(MessageReader(written.bytes(), "cdr"));
  EXPECT_EQ(read.resolution_m, 0.25);
  EXPECT_EQ(read.width, 3u);
  EXPECT_TRUE(read.origin == grid.origin);
  EXPECT_EQ(read.cells, grid.cells);
}

TEST(MessageDefinitions, HaveEveryTypeWithinOnce) {
  const std::string text = message_definition("nav_msgs/msg/Odometry");
  for (const char* type : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point",
                           "geometry_msgs/Quaternion", "geometry_msgs/TwistWithCovariance"}) {
    const std::string head = std::string(80, '=') + "\nMSG: " + type + "\n";
    const std::size_t at = text.find(head);
    ASSERT_NE(at, std::string::npos) << type;
    EXPECT_EQ(text.find(head, at + 1), std::string::npos) << type;
  }
  EXPECT_THROW(message_definition("a/msg/B"), Error);
}

}  // namespace
}  // namespace parloc::test
