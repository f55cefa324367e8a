#include "common/io/bag_truth.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/io/topic_choice.h"
#include "common/ros/messages.h"
#include "common/ros/transform_tree.h"

namespace parloc {

namespace {

// Transforms above the base come from programs that need a while; so long they are waited for.
constexpr double kWait_s = 2.0;

/// The pose that a message of one of these types states.
PoseMessage pose_of(const MessageReader& in, const std::string& type) {
  if (type == "nav_msgs/Odometry") {
    const OdometryMessage odometry = read_odometry(in);
    return {odometry.header, odometry.pose};
  }
  if (type == "geometry_msgs/TransformStamped") {
    const TransformMessage transform = read_transform(in);
    return {transform.header, transform.T_parent_child};
  }
  return read_pose_stamped(in);
}

Trajectory poses_of_topic(BagReader& bag, const std::string& path, const LogChoice& choice) {
  TopicWish wish{choice.truth_topic,
                 "--truth-topic",
                 "true poses",
                 {"geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped",
                  "geometry_msgs/TransformStamped"}};
  if (!choice.truth_topic.empty()) wish.types.push_back("nav_msgs/Odometry");
  const std::size_t topic = choose_topic(bag, path, wish);
  std::vector<bool> wanted(bag.topics().size(), false);
  wanted[topic] = true;
  bag.select(wanted);
  Trajectory truth;
  std::string trouble;
  for (BagMessage message; bag.next(message);) {
    try {
      PoseMessage said =
          pose_of(MessageReader(message.bytes, bag.topics()[topic].encoding), bag.topics()[topic].type);
      if (normalise(said.pose)) truth.push_back({said.header.stamp_s, planar(said.pose)});
    } catch (const BrokenMessage& broken) {
      trouble = broken.why;
    }
  }
  if (truth.empty())
    throw input_error(path, 0,
                      fmt::format("{}: expected poses, found none{}{}", printable(bag.topics()[topic].name),
                                  trouble.empty() ? "" : "; ", trouble));
  return truth;
}

/// Follows the base through the transforms of a bag.
class FrameTruth {
 public:
  FrameTruth(std::string truth_frame, std::string base_frame)
      : truth_frame_(std::move(truth_frame)), base_frame_(std::move(base_frame)) {}

  void take(const TransformMessage& message, bool fixed) {
    tree_.add(message, fixed);
    for (const char* usual : {"base_footprint", "base_link"})
      if (base_frame_.empty() && tree_.knows(usual)) base_frame_ = usual;
    if (fixed || base_frame_.empty() || message.child_frame != moving_frame()) return;
    waiting_.push_back(message.header.stamp_s);
    while (!waiting_.empty() && waiting_.front() < message.header.stamp_s - kWait_s) look();
  }
  Trajectory end() {
    while (!waiting_.empty()) look();
    return std::move(truth_);
  }
  const std::string& base_frame() const { return base_frame_; }
  std::vector<std::string> frames() const { return tree_.frames(); }

 private:
  /// The nearest frame at or above the base that moves: its transforms say when the base was somewhere.
  std::string moving_frame() const {
    for (const std::string& frame : tree_.way_up(base_frame_))
      if (tree_.moves(frame)) return frame;
    return {};
  }
  void look() {
    const double stamp_s = waiting_.front();
    waiting_.pop_front();
    if (const auto T = tree_.find(truth_frame_, base_frame_, stamp_s))
      truth_.push_back({stamp_s, planar(*T)});
  }

  std::string truth_frame_, base_frame_;
  TransformTree tree_;
  std::deque<double> waiting_;
  Trajectory truth_;
};

Trajectory poses_of_frame(BagReader& bag, const std::string& path, const LogChoice& choice) {
  std::vector<bool> wanted;
  for (const BagTopic& topic : bag.topics()) wanted.push_back(holds_transforms(topic));
  bag.select(wanted);
  FrameTruth found(choice.truth_frame, choice.base_frame);
  for (BagMessage message; bag.next(message);) {
    const BagTopic& topic = bag.topics()[message.topic];
    try {
      for (const TransformMessage& transform : read_transforms(MessageReader(message.bytes, topic.encoding)))
        found.take(transform, holds_fixed_transforms(topic));
    } catch (const BrokenMessage&) {
      continue;  // the log's own reader counts it
    }
  }
  Trajectory truth = found.end();
  if (truth.empty())
    throw input_error(
        path, 0,
        fmt::format("--truth-frame {}: no transform from it to the robot ({}) in /tf (frames: {})",
                    printable(choice.truth_frame),
                    found.base_frame().empty() ? "--base-frame" : printable(found.base_frame()),
                    printable(fmt::format("{}", fmt::join(found.frames(), ", ")))));
  return truth;
}

}  // namespace

Trajectory read_bag_truth(const std::string& path, const LogChoice& choice) {
  const auto bag = open_bag(path);
  return choice.truth_frame.empty() ? poses_of_topic(*bag, path, choice) : poses_of_frame(*bag, path, choice);
}

}  // namespace parloc
