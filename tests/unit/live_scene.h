// The messages of simulated drives, for the tests of localizers that are fed with messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/inputs/bag_log.h"
#include "common/live/live_localizer.h"
#include "tests/unit/simulated.h"
#include "tests/unit/temp_file.h"
#include "tools/log/converted_log.h"

namespace parloc {

struct Message {
  TopicRole role;
  std::string topic, bytes;
};

inline std::string bag_of(const SimulatedLog& log) {
  std::string bytes;
  const auto out = tools::convert_to_mcap([&](std::string_view part) { bytes += part; });
  for (const LogRecord& record : log.records) out->write(record);
  out->finish();
  return bytes;
}

inline std::vector<Message> messages_of(const std::string& path) {
  const auto bag = open_bag(path);
  const std::vector<TopicRole> roles = choose_topics(*bag, {}, path);
  bag->select(std::vector<bool>(roles.size(), true));
  std::vector<Message> messages;
  for (BagMessage message; bag->next(message);)
    messages.push_back({roles[message.topic], bag->topics()[message.topic].name, std::string(message.bytes)});
  return messages;
}

inline Config quick_config() {
  Config config;
  config.backend = BackendChoice::cpu;
  config.threads = 2;
  config.particles = 500;
  config.scan.max_beams = 30;
  return config;
}

/// The hall, and spinning on the spot with scans that take 0.1 s each.
struct Scene {
  const GridMap& map;
  Config config = quick_config();
  test::TempFile bag;
  std::vector<Message> messages;

  Scene(const SimulatedLog& log, const GridMap& on)
      : map(on), bag("drive.mcap", bag_of(log)), messages(messages_of(bag.path())) {}
};

inline Scene hall_scene() {
  return {hall_drive(), fine_hall()};
}

inline std::vector<LiveAnswer> feed(LiveLocalizer& robot, const std::vector<Message>& messages) {
  std::vector<LiveAnswer> answers;
  for (const Message& message : messages) {
    robot.take(message.role, message.topic, message.bytes);
    while (auto answer = robot.next()) answers.push_back(*answer);
  }
  return answers;
}

inline bool has_odometry(const std::vector<Message>& messages) {
  for (const Message& message : messages)
    if (message.role == TopicRole::odometry) return true;
  return false;
}

inline LiveLocalizer robot_of(const Scene& scene) {
  LiveLocalizer robot(scene.config, has_odometry(scene.messages));
  robot.put(robot.prepare(scene.config, scene.map));
  return robot;
}

inline LiveStart about(const Pose& pose) {
  return {pose, covariance_of(0.2, 0.2, 0.1)};
}

}  // namespace parloc
