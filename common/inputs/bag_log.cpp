#include "common/inputs/bag_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/inputs/cloud_scan.h"
#include "common/io/odometry_joiner.h"
#include "common/math/portable64.h"
#include "common/ros/messages.h"
#include "common/ros/transform_tree.h"

namespace parloc {

namespace {

constexpr std::size_t kMostMessages = 20;
constexpr double kMostTilt_rad = 5.0 * kPi / 180.0;
constexpr double kMostBearing_rad = 4.0 * kPi;
// So many scans, over so long, are kept until somebody says where their LiDAR sits.
constexpr std::size_t kMostUnplaced = 1000;
constexpr std::size_t kMostWaitingBytes = std::size_t{64} << 20;  // of clouds
constexpr double kLatestTransform_s = 10.0;

class BagLog final : public LogReader {
 public:
  BagLog(const std::string& path, const LogChoice& choice)
      : name_(path), choice_(choice), bag_(open_bag(path)), base_frame_(choice.base_frame) {
    roles_ = choose_topics(*bag_, choice_, name_);
    std::vector<bool> wanted;
    for (const TopicRole role : roles_) wanted.push_back(role != TopicRole::none);
    from_transforms_ = std::find(roles_.begin(), roles_.end(), TopicRole::odometry) == roles_.end();
    says_base_ =
        !from_transforms_ || std::find(roles_.begin(), roles_.end(), TopicRole::transforms) != roles_.end();
    bag_->select(wanted);
  }

  bool next(LogRecord& record) override {
    while (!next_ready(record)) {
      if (ended_ && placed_ == 0) throw input_error(name_, 0, no_scans());
      if (ended_ && !any_scan_) throw input_error(name_, 0, joiner_.why_none());
      if (ended_) return false;
      BagMessage message;
      if (bag_->next(message)) {
        take(message);
      } else {
        end();
      }
    }
    if (record.kind == RecordKind::scan) count_scan(record);
    return true;
  }

  const LogWarnings& warnings() const override {
    const std::size_t seen = counted_.broken_lines + counted_.backward_stamps + counted_.beam_count_changes +
                             bag_->faults().count + tree_.contradictions().size() + sensor_on_.size() +
                             joiner_.scans_before() + joiner_.scans_after();
    if (std::exchange(told_, seen) != seen) tell_all();
    return warnings_;
  }

  double progress() const override { return bag_->progress(); }

 private:
  /// A scan that waits to be placed on the robot; of a cloud, the message that it is made from.
  struct Unplaced {
    LogRecord record;
    std::string frame;
    std::string cloud, encoding;
  };

  void tell_all() const;
  bool next_ready(LogRecord& record);
  void take(const BagMessage& message);
  void take_scan(const LaserScanMessage& message, const std::string& topic);
  void take_odometry(const OdometryMessage& message);
  void take_transforms(const std::vector<TransformMessage>& messages, bool fixed);
  void place_scans();
  bool place(Unplaced& scan);
  void end();
  Error no_place(const Unplaced& scan) const;
  Error no_odometry() const;
  std::string no_scans() const;
  Error why_unplaced() const {
    const Unplaced& first = unplaced_.front();
    return base_frame_.empty() && !is_mounted(first.record.scan.sensor) ? no_odometry() : no_place(first);
  }
  void count_scan(const LogRecord& record);
  bool is_mounted(const std::string& sensor) const {
    return std::find(choice_.mounted.begin(), choice_.mounted.end(), sensor) != choice_.mounted.end();
  }
  static void tell(LogWarnings& warnings, std::string what) {
    if (warnings.messages.size() < kMostMessages) warnings.messages.push_back(std::move(what));
  }
  void count_broken(const std::string& why) {
    ++counted_.broken_lines;
    tell(counted_, fmt::format("{}: message {}: {}", name_, line_, why));
  }

  std::string name_;
  LogChoice choice_;
  std::unique_ptr<BagReader> bag_;
  std::vector<TopicRole> roles_;
  bool says_base_ = false;        ///< There is a topic of odometry, or of transforms.
  bool from_transforms_ = false;  ///< Odometry is the transform of the odometry frame's child.
  std::string base_frame_;        ///< Empty: nobody said it yet.
  TransformTree tree_;
  std::deque<Unplaced> unplaced_;
  std::size_t waiting_bytes_ = 0;  ///< Of clouds among them.
  OdometryJoiner joiner_;
  std::deque<LogRecord> ready_;  ///< Without odometry.
  LaserScanMessage scan_message_;
  std::size_t line_ = 0;  ///< Of the messages that were taken.
  bool ended_ = false;
  std::size_t placed_ = 0;
  LogWarnings counted_;
  mutable LogWarnings warnings_;  ///< What warnings() said last, and how many troubles that were.
  mutable std::size_t told_ = 0;
  std::map<std::string, std::size_t> beams_of_sensor_;
  std::map<std::string, std::string> frame_of_sensor_, sensor_on_;  ///< And the first sensor above a frame.
  double last_scan_stamp_s_ = 0.0;
  bool any_scan_ = false;
};

void BagLog::tell_all() const {
  warnings_ = counted_;
  const BagFaults& faults = bag_->faults();
  warnings_.broken_lines += faults.count;
  for (const std::string& fault : faults.messages) tell(warnings_, fault);
  for (const TransformTree::Contradiction& said : tree_.contradictions())
    if (const auto sensor = sensor_on_.find(said.frame); sensor != sensor_on_.end())
      warnings_.notes.push_back({LogNote::About::mount, sensor->second, said.text});
  for (std::string& line : joiner_.left_out(name_)) tell(warnings_, std::move(line));
}

bool BagLog::next_ready(LogRecord& record) {
  if (!choice_.without_odometry) return joiner_.next(record);
  if (ready_.empty()) return false;
  record = std::move(ready_.front());
  ready_.pop_front();
  return true;
}

void BagLog::take(const BagMessage& message) {
  ++line_;
  const BagTopic& topic = bag_->topics()[message.topic];
  try {
    const MessageReader in(message.bytes, topic.encoding);
    switch (roles_[message.topic]) {
      case TopicRole::none:
        break;
      case TopicRole::scan:
        read_laser_scan(in, scan_message_);
        take_scan(scan_message_, topic.name);
        break;
      case TopicRole::multi_echo_scan:
        read_multi_echo_scan(in, scan_message_);
        take_scan(scan_message_, topic.name);
        break;
      case TopicRole::cloud: {
        const PointCloudMessage cloud = read_point_cloud(in);
        Unplaced waiting;
        waiting.record.kind = RecordKind::scan;
        waiting.record.stamp_s = waiting.record.scan.stamp_s = cloud.header.stamp_s;
        waiting.record.scan.sensor = sensor_name(topic.name);
        waiting.record.line = line_;
        waiting.frame = cloud.header.frame;
        waiting.cloud = message.bytes;
        waiting.encoding = topic.encoding;
        waiting_bytes_ += waiting.cloud.size();
        unplaced_.push_back(std::move(waiting));
        break;
      }
      case TopicRole::odometry:
        take_odometry(read_odometry(in));
        break;
      case TopicRole::transforms:
        take_transforms(read_transforms(in), false);
        break;
      case TopicRole::fixed_transforms:
        take_transforms(read_transforms(in), true);
        break;
    }
  } catch (const BrokenMessage& broken) {
    count_broken(fmt::format("{}: {}", printable(topic.name), broken.why));
  }
  place_scans();
}

void BagLog::take_scan(const LaserScanMessage& message, const std::string& topic) {
  const std::size_t beams = message.ranges_m.size();
  if (beams == 0) throw BrokenMessage{"expected at least one range, found 0"};
  const double last_rad = static_cast<double>(message.angle_step_rad) * static_cast<double>(beams - 1);
  if (!(std::fabs(message.angle_min_rad) <= kMostBearing_rad) || !(std::fabs(last_rad) <= kMostBearing_rad))
    throw BrokenMessage{"expected beams within two turns"};
  if (beams > 1 && message.angle_step_rad == 0.0f) throw BrokenMessage{"expected an angle step, found 0"};
  const auto positive = [](float value) {
    return std::isfinite(value) && value > 0.0f ? static_cast<double>(value) : 0.0;
  };
  Unplaced waiting;
  waiting.frame = message.header.frame;
  LogRecord& record = waiting.record;
  record.kind = RecordKind::scan;
  record.stamp_s = message.header.stamp_s;
  record.line = line_;
  Scan& scan = record.scan;
  scan.stamp_s = record.stamp_s;
  scan.sensor = sensor_name(topic);
  scan.angle_min_rad = message.angle_min_rad;
  scan.angle_step_rad = message.angle_step_rad;
  scan.range_min_m = positive(message.range_min_m);
  scan.range_max_m = positive(message.range_max_m);
  scan.scan_time_s = positive(message.time_step_s) * static_cast<double>(beams - 1);
  scan.ranges_m = message.ranges_m;
  unplaced_.push_back(std::move(waiting));
}

void BagLog::take_odometry(const OdometryMessage& message) {
  RigidTransform T_odom_child = message.pose;
  if (!normalise(T_odom_child))
    throw BrokenMessage{"expected a finite pose with a quaternion of unit length"};
  if (base_frame_.empty()) base_frame_ = message.child_frame;
  // Some write no child frame: then it is the robot's base, by the names that are usual.
  for (const char* usual : {"base_footprint", "base_link"})
    if (base_frame_.empty() && tree_.knows(usual)) base_frame_ = usual;
  if (!message.child_frame.empty() && !base_frame_.empty() && message.child_frame != base_frame_) {
    const auto T_child_base = tree_.find(message.child_frame, base_frame_, message.header.stamp_s);
    if (!T_child_base) return;  // it is not known yet
    T_odom_child = compose(T_odom_child, *T_child_base);
  }
  if (!choice_.without_odometry) joiner_.add_odometry(message.header.stamp_s, planar(T_odom_child), line_);
}

void BagLog::take_transforms(const std::vector<TransformMessage>& messages, bool fixed) {
  const std::string odom = choice_.odometry_frame.empty() ? "odom" : choice_.odometry_frame;
  for (const TransformMessage& message : messages) {
    tree_.add(message, fixed);
    const bool is_odometry = from_transforms_ && !fixed && message.header.frame == odom;
    if (!is_odometry || tree_.parent_of(message.child_frame) != odom) continue;
    if (base_frame_.empty()) base_frame_ = message.child_frame;
    if (choice_.without_odometry) continue;
    if (const auto T_odom_base = tree_.find(odom, base_frame_, message.header.stamp_s))
      joiner_.add_odometry(message.header.stamp_s, planar(*T_odom_base), line_);
  }
}

// Where the LiDAR sits, and for a cloud what it sees from there. False if that is not known yet.
bool BagLog::place(Unplaced& waiting) {
  LogRecord& record = waiting.record;
  Scan& scan = record.scan;
  RigidTransform T_base_sensor;
  // Where nothing says what moves, the LiDAR is the robot.
  const bool is_robot = choice_.without_odometry && base_frame_.empty() && !says_base_;
  if (!is_robot && !is_mounted(scan.sensor) && (waiting.frame.empty() || waiting.frame != base_frame_)) {
    if (base_frame_.empty()) return false;
    const auto found = tree_.find(base_frame_, waiting.frame, record.stamp_s);
    if (!found) return false;
    T_base_sensor = *found;
    if (std::string& known = frame_of_sensor_[scan.sensor]; known != waiting.frame) {
      known = waiting.frame;
      for (const std::string& frame : tree_.way_up(waiting.frame)) sensor_on_.emplace(frame, scan.sensor);
    }
  }
  if (!waiting.cloud.empty()) {
    const PointCloudMessage cloud = read_point_cloud(MessageReader(waiting.cloud, waiting.encoding));
    scan_from_cloud(cloud, T_base_sensor, {choice_.cloud_low, choice_.cloud_high}, scan);
    return true;
  }
  const PlanarMount mount = planar_mount(T_base_sensor);
  if (mount.tilt_rad > kMostTilt_rad)
    throw input_error(
        name_, 0,
        fmt::format("{} is tilted by {:.0f} degrees against {}: expected a LiDAR whose scans lie in the "
                    "floor's plane "
                    "(within 5 degrees)",
                    printable(waiting.frame), mount.tilt_rad * 180.0 / kPi, printable(base_frame_)));
  scan.T_base_sensor = mount.T_base_sensor;
  scan.upside_down = mount.upside_down;
  return true;
}

void BagLog::place_scans() {
  while (!unplaced_.empty()) {
    Unplaced& waiting = unplaced_.front();
    try {
      if (!place(waiting)) break;
      ++placed_;
      if (choice_.without_odometry) {
        ready_.push_back(std::move(waiting.record));
      } else {
        joiner_.add_scan(std::move(waiting.record));
      }
    } catch (const BrokenMessage& broken) {
      count_broken(broken.why);
    }
    waiting_bytes_ -= waiting.cloud.size();
    unplaced_.pop_front();
  }
  if (unplaced_.empty()) return;
  const bool long_ago =
      unplaced_.back().record.stamp_s > unplaced_.front().record.stamp_s + kLatestTransform_s;
  if (unplaced_.size() > kMostUnplaced || waiting_bytes_ > kMostWaitingBytes ||
      (long_ago && !base_frame_.empty()))
    throw why_unplaced();
}

Error BagLog::no_place(const Unplaced& scan) const {
  const std::vector<std::string> frames = tree_.frames();
  const std::string known =
      frames.empty() ? "there are no transforms"
                     : fmt::format("frames: {}", printable(fmt::format("{}", fmt::join(frames, ", "))));
  const std::string sensor = printable(scan.record.scan.sensor);
  return input_error(
      name_, 0,
      fmt::format(
          "no transform from {} to {} in /tf or /tf_static ({}): give the robot's frame with --base-frame, "
          "or the LiDAR's place with lidars: {}: {{x: 0, y: 0, yaw: 0}} in --config",
          printable(base_frame_), printable(scan.frame), known, sensor));
}

Error BagLog::no_odometry() const {
  const std::vector<std::string> frames = tree_.frames();
  if (from_transforms_)
    return input_error(
        name_, 0,
        fmt::format(
            "no transform from {} to the robot in /tf (frames: {}): give --odom-frame or --odom-topic; "
            "parloc slam can do without (slam.odometry: scans)",
            choice_.odometry_frame.empty() ? "odom" : printable(choice_.odometry_frame),
            frames.empty() ? "none" : printable(fmt::format("{}", fmt::join(frames, ", ")))));
  return input_error(name_, 0, "expected odometry, found a topic without a usable message");
}

std::string BagLog::no_scans() const {
  std::string topics;
  for (std::size_t k = 0; k < roles_.size(); ++k)
    if (roles_[k] == TopicRole::scan || roles_[k] == TopicRole::multi_echo_scan ||
        roles_[k] == TopicRole::cloud)
      topics += (topics.empty() ? "" : ", ") + printable(bag_->topics()[k].name);
  const std::vector<std::string>& said = warnings().messages;
  return fmt::format("expected at least one scan on {}, found none{}{}", topics, said.empty() ? "" : "; ",
                     said.empty() ? "" : said.front());
}

void BagLog::end() {
  ended_ = true;
  joiner_.finish();
  if (!unplaced_.empty()) throw why_unplaced();
}

void BagLog::count_scan(const LogRecord& record) {
  if (any_scan_ && record.stamp_s < last_scan_stamp_s_) ++counted_.backward_stamps;
  any_scan_ = true;
  last_scan_stamp_s_ = record.stamp_s;
  std::size_t& beams = beams_of_sensor_[record.scan.sensor];
  if (beams != 0 && beams != record.scan.ranges_m.size()) ++counted_.beam_count_changes;
  beams = record.scan.ranges_m.size();
}

}  // namespace

std::unique_ptr<LogReader> open_bag_log(const std::string& path, const LogChoice& choice) {
  return std::make_unique<BagLog>(path, choice);
}

}  // namespace parloc
