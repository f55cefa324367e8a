#include "tools/log/bag_survey.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"
#include "common/inputs/topic_choice.h"

namespace parloc::tools {

namespace {

/// The one of that name, else the one with the most messages.
const TopicSurvey* likeliest(const std::vector<const TopicSurvey*>& topics, const std::string& name) {
  const TopicSurvey* best = nullptr;
  for (const TopicSurvey* topic : topics) {
    if (topic->topic.name == name) return topic;
    if (best == nullptr || topic->recorded.count() > best->recorded.count()) best = topic;
  }
  return best;
}

std::string names_of(const std::vector<const TopicSurvey*>& topics) {
  std::string text;
  for (const TopicSurvey* topic : topics) text += (text.empty() ? "" : ", ") + printable(topic->topic.name);
  return text;
}

/// Chooses among several, and says so.
std::string choose(const std::vector<const TopicSurvey*>& topics, const char* usual, const char* option,
                   const char* what, SuggestedChoice& suggested) {
  const std::string& name = likeliest(topics, usual)->topic.name;
  if (topics.size() > 1) {
    suggested.options.push_back(fmt::format("{} {}", option, printable(name)));
    suggested.reasons.push_back(fmt::format("{} topics hold {} ({}): {} is the {}", topics.size(), what,
                                            names_of(topics), printable(name),
                                            name == usual ? "usual one" : "one with the most messages"));
  }
  return name;
}

}  // namespace

std::size_t BagSurvey::messages() const {
  std::size_t sum = 0;
  for (const TopicSurvey& topic : topics) sum += topic.recorded.count();
  return sum;
}

std::vector<const TopicSurvey*> BagSurvey::of_type(const std::string& type) const {
  std::vector<const TopicSurvey*> found;
  for (const TopicSurvey& topic : topics)
    if (topic.topic.type == type && topic.recorded.count() > 0) found.push_back(&topic);
  return found;
}

BagSurvey survey_bag(BagReader& bag, const std::function<void(double)>& progress,
                     const std::function<bool()>& stop) {
  BagSurvey survey;
  survey.container = bag.container();
  for (const BagTopic& topic : bag.topics()) survey.topics.push_back({topic, {}, 0});
  std::size_t count = 0;
  for (BagMessage message; !stop() && bag.next(message); ++count) {
    TopicSurvey& topic = survey.topics[message.topic];
    topic.recorded.add(static_cast<double>(message.stamp_ns) / 1e9);
    topic.bytes += message.bytes.size();
    if (count % 256 == 0) progress(bag.progress());
  }
  survey.faults = bag.faults();
  return survey;
}

SuggestedChoice suggest_choice(const BagSurvey& bag, const LogChoice& given) {
  SuggestedChoice suggested;
  suggested.choice = given;
  if (given.scan_topic.empty()) {
    std::vector<const TopicSurvey*> scans = bag.of_type("sensor_msgs/LaserScan");
    for (const TopicSurvey* more : bag.of_type("sensor_msgs/MultiEchoLaserScan")) scans.push_back(more);
    const std::vector<const TopicSurvey*> clouds = bag.of_type("sensor_msgs/PointCloud2");
    if (!scans.empty()) {
      suggested.choice.scan_topic = choose(scans, "/scan", "--scan-topic", "scans", suggested);
    } else if (!clouds.empty()) {
      suggested.choice.scan_topic = likeliest(clouds, "/points")->topic.name;
      suggested.options.push_back("--scan-topic " + printable(suggested.choice.scan_topic));
      suggested.reasons.push_back("there are no scans: clouds of points are made into some");
    }
  }
  const std::vector<const TopicSurvey*> odometry = bag.of_type("nav_msgs/Odometry");
  const bool transforms = std::any_of(bag.topics.begin(), bag.topics.end(), [](const TopicSurvey& t) {
    return holds_transforms(t.topic) && !holds_fixed_transforms(t.topic) && t.recorded.count() > 0;
  });
  if (given.odometry_topic.empty() && given.odometry_frame.empty() && !odometry.empty())
    suggested.choice.odometry_topic = choose(odometry, "/odom", "--odom-topic", "odometry", suggested);
  suggested.no_odometry = odometry.empty() && !transforms;
  suggested.choice.without_odometry = given.without_odometry || suggested.no_odometry;
  const std::vector<const TopicSurvey*> maps = bag.of_type("nav_msgs/OccupancyGrid");
  suggested.map_topic = !given.map_topic.empty() ? given.map_topic
                        : maps.empty()           ? ""
                                                 : choose(maps, "/map", "--map-topic", "a map", suggested);
  return suggested;
}

}  // namespace parloc::tools
