// The messages of a robot, put together into what a filter needs: scans with where their LiDAR sits and the
// odometry at their time.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/inputs/topic_choice.h"
#include "common/io/log.h"
#include "common/io/odometry_joiner.h"
#include "common/ros/messages.h"
#include "common/ros/transform_tree.h"

namespace parloc {

/// What there is to be read.
struct MessageSources {
  std::string name;  ///< The bag's, or the robot's, for messages to people.
  bool odometry_topic = false;
  bool transforms = false;
  /// Messages come as the robot drives. A scan that cannot be used is left out and counted, where a bag
  /// throws, and odometry comes out as soon as it is known.
  bool live = false;
};

/// Takes messages in the order in which they came and gives records, as docs/bags.md says. Memory is bounded.
/// Deterministic: the same messages give the same records.
class RobotMessages {
 public:
  RobotMessages(const MessageSources& sources, const LogChoice& choice);

  /// A message that is broken is skipped and counted. `encoding` as MessageReader's. Throws Error{input} for
  /// scans of which nobody says where their LiDAR sits, or that do not lie in the floor's plane; not if live.
  void take(TopicRole role, const std::string& topic, const std::string& encoding, std::string_view bytes);
  /// No more comes. Throws as `take`.
  void finish();
  /// False: more has to be taken first, or there is no more.
  bool next(LogRecord& record);

  /// The robot's clock was set, or its bag begun anew: what was taken is forgotten, but for where frames are
  /// that do not move.
  void forget();

  std::size_t placed() const { return placed_; }                                ///< Scans.
  std::size_t waiting() const { return unplaced_.size() + joiner_.waiting(); }  ///< Likewise.
  const OdometryJoiner& joiner() const { return joiner_; }
  /// Whatever was worked around so far.
  LogWarnings warnings() const;
  /// Live: what was worked around since the last call, line by line, at most 100; warnings() do not have it.
  std::vector<std::string> take_news() { return std::exchange(news_, {}); }
  /// Changes whenever there is something new in warnings().
  std::size_t troubles() const;

 private:
  /// A scan that waits to be placed on the robot; of a cloud, the message that it is made from.
  struct Unplaced {
    LogRecord record;
    std::string frame;
    std::string cloud, encoding;
  };

  void take_scan(const LaserScanMessage& message, const std::string& topic);
  void take_cloud(const PointCloudMessage& message, const std::string& topic, std::string_view bytes,
                  const std::string& encoding);
  void take_odometry(const OdometryMessage& message);
  void take_transforms(const std::vector<TransformMessage>& messages, bool fixed);
  void place_scans();
  void take_placed(LogRecord record);
  bool place(Unplaced& scan);
  void drop(std::size_t k);
  bool waits_too_long() const;
  Error no_place(const Unplaced& scan) const;
  Error no_odometry() const;
  Error why_unplaced() const;
  void count(const std::string& line);
  bool is_mounted(const std::string& sensor) const;
  void count_broken(const std::string& why);

  MessageSources sources_;
  LogChoice choice_;
  bool from_transforms_;    ///< Odometry is the transform of the odometry frame's child.
  std::string base_frame_;  ///< Empty: nobody said it yet.
  TransformTree tree_;
  std::deque<Unplaced> unplaced_;
  std::size_t waiting_bytes_ = 0;  ///< Of clouds among them.
  OdometryJoiner joiner_;
  std::deque<LogRecord> ready_;  ///< Without odometry.
  LaserScanMessage scan_message_;
  std::size_t line_ = 0;  ///< Of the messages that were taken.
  std::size_t placed_ = 0;
  LogWarnings counted_;
  std::vector<std::string> news_;  ///< Live: lines that nobody has taken yet.
  std::map<std::string, std::string> frame_of_sensor_, sensor_on_;  ///< And the first sensor above a frame.
};

}  // namespace parloc
