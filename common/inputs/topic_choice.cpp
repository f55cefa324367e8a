#include "common/inputs/topic_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/error.h"
#include "common/file/nearest_name.h"

namespace parloc {

namespace {

constexpr const char* kLaserScan = "sensor_msgs/LaserScan";
constexpr const char* kMultiEcho = "sensor_msgs/MultiEchoLaserScan";
constexpr const char* kCloud = "sensor_msgs/PointCloud2";
constexpr const char* kOdometry = "nav_msgs/Odometry";

std::string with_slash(const std::string& topic) {
  return topic.empty() || topic.front() == '/' ? topic : "/" + topic;
}

/// What stands between the commas.
std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names(1);
  for (const char c : list) {
    if (c == ',') names.emplace_back();
    if (c != ',' && c != ' ') names.back() += c;
  }
  std::erase(names, "");
  return names;
}

/// The topics of these types.
std::vector<std::size_t> of_types(const std::vector<BagTopic>& topics,
                                  const std::vector<std::string>& types) {
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < topics.size(); ++k)
    if (std::find(types.begin(), types.end(), topics[k].type) != types.end()) found.push_back(k);
  return found;
}

/// Those that have messages, if any of them has.
std::vector<std::size_t> with_messages(const BagReader& bag, std::vector<std::size_t> which) {
  if (which.size() < 2) return which;
  std::vector<std::size_t> filled;
  for (const std::size_t k : which)
    if (!bag.is_empty(k)) filled.push_back(k);
  if (filled.empty()) return which;
  return filled;
}

std::string list_text(const std::vector<BagTopic>& topics, const std::vector<std::size_t>& which) {
  constexpr std::size_t most = 12;
  std::string text;
  for (std::size_t k = 0; k < which.size() && k < most; ++k)
    text += fmt::format("{}{}", k > 0 ? ", " : "", printable(topics[which[k]].name));
  if (which.size() > most) text += fmt::format(" and {} more", which.size() - most);
  return text;
}

std::string all_text(const std::vector<BagTopic>& topics) {
  if (topics.empty()) return "no topic at all";
  std::string text;
  for (std::size_t k = 0; k < topics.size() && k < 12; ++k)
    text += fmt::format("{}{} ({})", k > 0 ? ", " : "", printable(topics[k].name), printable(topics[k].type));
  return topics.size() > 12 ? text + fmt::format(" and {} more", topics.size() - 12) : text;
}

/// The topic of that name among those that have one of the types.
std::size_t named(const std::vector<BagTopic>& topics, const std::string& bag_name, const TopicWish& wish) {
  const std::string wanted = with_slash(wish.name);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < topics.size(); ++k) {
    names.push_back(topics[k].name);
    if (with_slash(topics[k].name) != wanted) continue;
    if (std::find(wish.types.begin(), wish.types.end(), topics[k].type) != wish.types.end()) return k;
    throw input_error(bag_name, 0,
                      fmt::format("{} {}: expected {}, found {}", wish.option, printable(wanted),
                                  wish.types.front(), printable(topics[k].type)));
  }
  const std::string nearest(names.empty() ? std::string_view{} : nearest_name(wanted, names));
  throw input_error(bag_name, 0,
                    fmt::format("{} {}: no such topic{}; there are {}", wish.option, printable(wanted),
                                nearest.empty() ? "" : fmt::format(", did you mean {}?", printable(nearest)),
                                all_text(topics)));
}

std::vector<std::size_t> choose_scans(const BagReader& bag, const LogChoice& choice,
                                      const std::string& bag_name) {
  const std::vector<BagTopic>& topics = bag.topics();
  std::vector<std::size_t> chosen;
  for (const std::string& name : names_in(choice.scan_topic))
    chosen.push_back(
        named(topics, bag_name, {name, "--scan-topic", "scans", {kLaserScan, kMultiEcho, kCloud}}));
  if (!chosen.empty()) return chosen;
  const std::vector<std::size_t> scans = with_messages(bag, of_types(topics, {kLaserScan, kMultiEcho}));
  if (scans.size() == 1) return scans;
  if (scans.size() > 1)
    throw input_error(
        bag_name, 0,
        fmt::format(
            "{} topics hold scans: {}; choose with --scan-topic (several LiDARs: with commas between)",
            scans.size(), list_text(topics, scans)));
  const std::vector<std::size_t> clouds = of_types(topics, {kCloud});
  if (!clouds.empty())
    throw input_error(
        bag_name, 0,
        fmt::format(
            "expected a topic of {}, found only clouds of points: {}; --scan-topic makes scans of one",
            kLaserScan, list_text(topics, clouds)));
  throw input_error(bag_name, 0,
                    fmt::format("expected a topic of {}, found {}", kLaserScan, all_text(topics)));
}

/// None: transforms are the odometry.
std::optional<std::size_t> choose_odometry(const BagReader& bag, const LogChoice& choice,
                                           const std::string& bag_name) {
  const std::vector<BagTopic>& topics = bag.topics();
  if (!choice.odometry_topic.empty())
    return named(topics, bag_name, {choice.odometry_topic, "--odom-topic", "odometry", {kOdometry}});
  const std::vector<std::size_t> found = with_messages(bag, of_types(topics, {kOdometry}));
  if (found.empty() || (found.size() == 1 && bag.is_empty(found.front())) || !choice.odometry_frame.empty())
    return std::nullopt;
  if (found.size() > 1)
    throw input_error(
        bag_name, 0,
        fmt::format("{} topics hold odometry: {}; choose with --odom-topic, or --odom-frame for /tf",
                    found.size(), list_text(topics, found)));
  return found.front();
}

}  // namespace

std::string sensor_name(const std::string& topic) {
  return topic.empty() || topic.front() != '/' ? topic : topic.substr(1);
}

std::size_t choose_topic(const BagReader& bag, const std::string& bag_name, const TopicWish& wish) {
  const std::vector<BagTopic>& topics = bag.topics();
  if (!wish.name.empty()) return named(topics, bag_name, wish);
  const std::vector<std::size_t> found = with_messages(bag, of_types(topics, wish.types));
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw input_error(
        bag_name, 0,
        fmt::format("expected {}: a topic of {}, found {}{}{}", wish.what, fmt::join(wish.types, " or "),
                    all_text(topics), wish.otherwise.empty() ? "" : "; ", wish.otherwise));
  throw input_error(bag_name, 0,
                    fmt::format("{} topics hold {}: {}; choose with {}", found.size(), wish.what,
                                list_text(topics, found), wish.option));
}

bool holds_transforms(const BagTopic& topic) {
  return topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage";
}

bool holds_fixed_transforms(const BagTopic& topic) {
  return holds_transforms(topic) && topic.name.ends_with("tf_static");
}

std::vector<TopicRole> choose_topics(const BagReader& bag, const LogChoice& choice,
                                     const std::string& bag_name) {
  const std::vector<BagTopic>& topics = bag.topics();
  std::vector<TopicRole> roles(topics.size(), TopicRole::none);
  for (const std::size_t k : choose_scans(bag, choice, bag_name))
    roles[k] = topics[k].type == kLaserScan   ? TopicRole::scan
               : topics[k].type == kMultiEcho ? TopicRole::multi_echo_scan
                                              : TopicRole::cloud;
  if (const auto k = choose_odometry(bag, choice, bag_name)) roles[*k] = TopicRole::odometry;
  bool transforms = false;
  for (std::size_t k = 0; k < topics.size(); ++k) {
    if (!holds_transforms(topics[k])) continue;
    const bool fixed = holds_fixed_transforms(topics[k]);
    roles[k] = fixed ? TopicRole::fixed_transforms : TopicRole::transforms;
    transforms = transforms || !fixed;
  }
  const bool odometry = std::find(roles.begin(), roles.end(), TopicRole::odometry) != roles.end();
  if (!odometry && !transforms && !choice.without_odometry)
    throw input_error(
        bag_name, 0,
        fmt::format("expected odometry: a topic of {} or /tf, found {}; parloc slam can do without "
                    "(slam.odometry: scans)",
                    kOdometry, all_text(topics)));
  return roles;
}

}  // namespace parloc
