// A localizer that is fed with a robot's messages: bytes in, bytes out.
#include "common/live/live_localizer.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "common/config/nav2_parameters.h"
#include "common/error.h"
#include "common/inputs/map_message.h"
#include "common/live/answer_messages.h"
#include "common/live/live_slam.h"
#include "common/ros/messages.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

std::string_view view(const nb::bytes& data) {
  return {data.c_str(), data.size()};
}
nb::bytes bytes(const MessageWriter& message) {
  return nb::bytes(message.bytes().data(), message.bytes().size());
}

TopicRole role_of(const std::string& name) {
  static const std::map<std::string, TopicRole> roles{{"scan", TopicRole::scan},
                                                      {"multi_echo_scan", TopicRole::multi_echo_scan},
                                                      {"cloud", TopicRole::cloud},
                                                      {"odometry", TopicRole::odometry},
                                                      {"transforms", TopicRole::transforms},
                                                      {"fixed_transforms", TopicRole::fixed_transforms}};
  const auto found = roles.find(name);
  if (found == roles.end())
    throw Error(ErrorKind::usage,
                "role: expected scan, multi_echo_scan, cloud, odometry, transforms or "
                "fixed_transforms, got " +
                    printable(name));
  return found->second;
}

template <class Robot>
void make(Robot* self, const ConfigBox* config, bool odometry_topic) {
  new (self) Robot(config_or_default(config), odometry_topic);
}

PreparedLocalizer prepare(const LiveLocalizer& robot, const ConfigBox& config, const GridMap& map) {
  const Config given = config.config;
  const nb::gil_scoped_release others;
  return robot.prepare(given, map);
}

/// All that can be said after a message, with the interpreter free for others.
std::vector<LiveAnswer> take(LiveLocalizer& robot, const std::string& role, const std::string& topic,
                             const nb::bytes& data) {
  const std::string_view message = view(data);
  const nb::gil_scoped_release others;
  robot.take(role_of(role), topic, message);
  std::vector<LiveAnswer> answers;
  while (auto answer = robot.next()) answers.push_back(std::move(*answer));
  return answers;
}

void start(LiveLocalizer& robot, const std::optional<PoseLike>& pose, const std::array<double, 3>& sigma,
           const std::optional<std::array<double, 36>>& ros_covariance) {
  LiveStart from;
  if (pose) from = {pose->pose, covariance_of(sigma[0], sigma[1], sigma[2])};
  if (pose && ros_covariance) from.covariance = covariance_from_ros(*ros_covariance);
  robot.start(from);
}

std::array<double, 3> sigmas(const LiveAnswer& answer) {
  const double* v = answer.estimate.filter.covariance.v;
  return {std::sqrt(v[0]), std::sqrt(v[4]), std::sqrt(v[8])};
}

std::optional<double> stamp_of_message(const nb::bytes& data) {
  try {
    MessageReader in(view(data), "cdr");
    const auto seconds = in.number<std::int32_t>();
    return seconds_of(seconds, in.number<std::uint32_t>());
  } catch (const BrokenMessage&) {
    return std::nullopt;
  }
}

GridMap map_of_message(const nb::bytes& data, const std::string& name) {
  const std::string_view message = view(data);
  const nb::gil_scoped_release others;
  try {
    return map_from_message(read_occupancy_grid(MessageReader(message, "cdr")), name);
  } catch (const BrokenMessage& broken) {
    throw Error(ErrorKind::input, name + ": " + broken.why);
  }
}

std::vector<std::tuple<std::string, std::string, std::string>> all_nav2_parameters() {
  std::vector<std::tuple<std::string, std::string, std::string>> all;
  for (const Nav2Parameter& p : nav2_parameters()) {
    std::string meaning = *p.setting != '\0' ? p.setting : "nav2's";
    if (*p.why != '\0') meaning += std::string(": ") + p.why;
    all.emplace_back(p.name, p.default_text, std::move(meaning));
  }
  return all;
}

void bind_live_answer(nb::module_& m) {
  nb::class_<LiveAnswer>(m, "LiveAnswer", "What is said to one scan.")
      .def_ro("stamp_s", &LiveAnswer::stamp_s, "Of the scan [s].")
      .def_ro("lidar", &LiveAnswer::lidar, "Whose scan it is: its topic without the slash.")
      .def_ro("odometry", &LiveAnswer::odometry, "T_odom_base at that time, as the robot said it.")
      .def_ro("T_map_odom", &LiveAnswer::T_map_odom, "What takes the odometry to the map.")
      .def_ro("why_skipped", &LiveAnswer::why_skipped, "Why the scan changed nothing; empty if it did.")
      .def_prop_ro(
          "pose", [](const LiveAnswer& a) { return a.estimate.filter.pose; }, "T_map_base.")
      .def_prop_ro("sigmas", &sigmas, "Standard deviations of x [m], y [m] and heading [rad].")
      .def_prop_ro(
          "weighted", [](const LiveAnswer& a) { return a.estimate.filter.weighted; },
          "Whether the scan was weighed; else the pose has moved with the odometry.")
      .def_prop_ro(
          "state", [](const LiveAnswer& a) { return name_of(a.estimate.health.state); },
          "tracking, ambiguous or lost.")
      .def_prop_ro(
          "probability", [](const LiveAnswer& a) { return a.estimate.health.probability; },
          "That the pose is within 0.5 m and 10 degrees.")
      .def(
          "pose_message",
          [](const LiveAnswer& a, const std::string& map, const std::string& odom) {
            return bytes(pose_message(a, {map, odom}));
          },
          "map"_a, "odom"_a, "geometry_msgs/PoseWithCovarianceStamped in CDR; frames by name.")
      .def(
          "map_odom_message",
          [](const LiveAnswer& a, const std::string& map, const std::string& odom, double tolerance_s) {
            return bytes(map_odom_message(a, {map, odom}, tolerance_s));
          },
          "map"_a, "odom"_a, "tolerance_s"_a,
          "tf2_msgs/TFMessage in CDR: the transform from map to odom, dated ahead by `tolerance_s`.")
      .def(
          "diagnostics_message",
          [](const LiveAnswer& a, const std::string& map, const std::string& odom, const std::string& name) {
            return bytes(diagnostics_message(a, {map, odom}, name));
          },
          "map"_a, "odom"_a, "name"_a,
          "diagnostic_msgs/DiagnosticArray in CDR: state, probability and the places that are possible.");
}

std::vector<LiveSlamAnswer> take_slam(LiveSlam& robot, const std::string& role, const std::string& topic,
                                      const nb::bytes& data) {
  const std::string_view message = view(data);
  const nb::gil_scoped_release others;
  robot.take(role_of(role), topic, message);
  std::vector<LiveSlamAnswer> answers;
  while (auto answer = robot.next()) answers.push_back(*answer);
  return answers;
}

void bind_live_slam(nb::module_& m) {
  nb::class_<LiveSlamAnswer>(m, "LiveSlamAnswer", "What is said to one scan while a map is made.")
      .def_ro("stamp_s", &LiveSlamAnswer::stamp_s, "Of the scan [s].")
      .def_ro("pose", &LiveSlamAnswer::pose, "T_map_base, by the most likely particle.")
      .def_ro("T_map_odom", &LiveSlamAnswer::T_map_odom, "What takes the odometry to the map.")
      .def_ro("taken_in", &LiveSlamAnswer::taken_in, "The robot had moved far enough for the scan to count.")
      .def(
          "map_odom_message",
          [](const LiveSlamAnswer& a, const std::string& map, const std::string& odom, double tolerance_s) {
            LiveAnswer answer;
            answer.stamp_s = a.stamp_s;
            answer.T_map_odom = a.T_map_odom;
            return bytes(map_odom_message(answer, {map, odom}, tolerance_s));
          },
          "map"_a, "odom"_a, "tolerance_s"_a,
          "tf2_msgs/TFMessage in CDR: the transform from map to odom, dated ahead by `tolerance_s`.");
  nb::class_<LiveSlam>(m, "LiveSlam",
                       "Mapping that is fed with the messages of a robot with ROS 2, in CDR: it makes what "
                       "`parloc slam` makes of a "
                       "bag of the same messages, but that it closes no loops. Nothing that a message holds "
                       "raises. One thread at a "
                       "time.")
      .def("__init__", &make<LiveSlam>, "config"_a = nb::none(), "odometry_topic"_a = false,
           "Frames, topics and LiDARs as LiveLocalizer has them; `config.slam` the rest.")
      .def("take", &take_slam, "role"_a, "topic"_a, "message"_a,
           "Takes a message and returns the answers that can be given with it; roles as LiveLocalizer's.")
      .def("forget", &LiveSlam::forget,
           "The robot's clock was set: messages are forgotten, map and pose stay.")
      .def("map_so_far", &LiveSlam::map_so_far, nb::call_guard<nb::gil_scoped_release>(),
           "The most likely particle's map; None before the first scan. Its cost grows with its area.")
      .def_prop_ro("waiting", &LiveSlam::waiting, "Scans without an answer yet.")
      .def("troubles", &LiveSlam::troubles, "Lines about what could not be used, each once.");
}

}  // namespace

void bind_live(nb::module_& m) {
  bind_live_answer(m);
  nb::class_<PreparedLocalizer>(m, "PreparedLocalizer",
                                "What LiveLocalizer.prepare() made: a localizer of a map, or a map for one.");
  nb::class_<LiveLocalizer>(
      m, "LiveLocalizer",
      "A localizer that is fed with the messages of a robot with ROS 2, in CDR: it says what `parloc run` "
      "says "
      "of a bag of the same messages, to the bit. Nothing that a message holds raises. One thread at a time; "
      "prepare() in any.")
      .def("__init__", &make<LiveLocalizer>, "config"_a = nb::none(), "odometry_topic"_a = false,
           "`config.log` says which frames are the odometry's and the robot's. Without `odometry_topic` the "
           "odometry is a transform. There is no map yet: scans are let pass.")
      .def("prepare", &prepare, "config"_a, "map"_a,
           "Makes what put() needs of configuration and map, which takes a while for a large map; beside the "
           "other methods, in any thread. Raises ConfigError and InputError.")
      .def(
          "put", [](LiveLocalizer& robot, PreparedLocalizer& ready) { robot.put(std::move(ready)); },
          "prepared"_a,
          "The next scan is answered on that map, with that configuration; `prepared` is used up. Where the "
          "map alone is another one, particles and all that was learnt stay: the same map again changes no "
          "bit. With another configuration a filter begins anew where the robot is, as unsure as it was. "
          "Raises UsageError for what was used up.")
      .def(
          "start", &start, "pose"_a = nb::none(), "sigma"_a = std::array<double, 3>{},
          "ros_covariance"_a = nb::none(),
          "The robot is at `pose` of the map, or anywhere. How far that is sure: `sigma` of x [m], y [m] and "
          "heading [rad], or the 36 numbers that ROS has for it. Raises InputError for a pose that is not on "
          "the map, and for a covariance that is none.")
      .def_prop_ro("has_map", &LiveLocalizer::has_map, "Whether a localizer was put in.")
      .def_prop_ro("started", &LiveLocalizer::started, "Whether scans are answered.")
      .def(
          "take", &take, "role"_a, "topic"_a, "message"_a,
          "Takes a message and returns the answers that can be given with it. `role`: scan, multi_echo_scan, "
          "cloud, odometry, transforms or fixed_transforms.")
      .def("weigh_next", &LiveLocalizer::weigh_next, "The next scan is weighed though the robot stands.")
      .def("forget", &LiveLocalizer::forget,
           "The robot's clock was set: messages are forgotten, the pose stays.")
      .def_prop_ro("waiting", &LiveLocalizer::waiting, "Scans without an answer yet.")
      .def("troubles", &LiveLocalizer::troubles, "Lines about what could not be used, each once.")
      .def(
          "particles_message",
          [](const LiveLocalizer& robot, const LiveAnswer& answer, const std::string& map,
             const std::string& odom, std::size_t most) {
            return bytes(particles_message(answer, {map, odom}, robot.localizer(), most));
          },
          "answer"_a, "map"_a, "odom"_a, "most"_a,
          "nav2_msgs/ParticleCloud in CDR of at most so many particles.")
      .def_prop_ro(
          "digest", [](const LiveLocalizer& robot) { return robot.localizer().filter().digest(); },
          "As `parloc run` prints it.");
  bind_live_slam(m);
  m.def("stamp_of_message", &stamp_of_message, "message"_a,
        "The stamp of a message in CDR that begins with a header [s]; None if it does not.");
  m.def("map_from_message", &map_of_message, "message"_a, "name"_a,
        "A nav_msgs/OccupancyGrid in CDR as a map. Raises InputError.");
  m.def(
      "map_message",
      [](const GridMap& map, double stamp_s, const std::string& frame) {
        return bytes(write_occupancy_grid(message_of_map(map, {stamp_s, frame})));
      },
      "map"_a, "stamp_s"_a = 0.0, "frame"_a = "map", "The map as nav_msgs/OccupancyGrid in CDR.");
  m.def("nav2_parameters", &all_nav2_parameters,
        "The parameters of nav2's amcl: name, nav2's default as text, and what each is here.");
}

}  // namespace parloc::python
