#include "common/inputs/robot_messages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/inputs/cloud_scan.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr std::size_t kMostTold = 20;
constexpr double kMostTilt_rad = 5.0 * kPi / 180.0;
constexpr double kMostBearing_rad = 4.0 * kPi;
// So many scans, over so long, are kept until somebody says where their LiDAR sits.
constexpr std::size_t kMostUnplaced = 1000, kMostUnplacedLive = 100;
constexpr std::size_t kMostWaitingBytes = std::size_t{64} << 20;  // of clouds
constexpr double kLatestTransform_s = 10.0;

void tell(LogWarnings& warnings, std::string what) {
  if (warnings.messages.size() < kMostTold) warnings.messages.push_back(std::move(what));
}

Scan scan_of(const LaserScanMessage& message, const std::string& topic) {
  const std::size_t beams = message.ranges_m.size();
  if (beams == 0) throw BrokenMessage{"expected at least one range, found 0"};
  const double last_rad = static_cast<double>(message.angle_step_rad) * static_cast<double>(beams - 1);
  if (!(std::fabs(message.angle_min_rad) <= kMostBearing_rad) || !(std::fabs(last_rad) <= kMostBearing_rad))
    throw BrokenMessage{"expected beams within two turns"};
  if (beams > 1 && message.angle_step_rad == 0.0f) throw BrokenMessage{"expected an angle step, found 0"};
  const auto positive = [](float value) {
    return std::isfinite(value) && value > 0.0f ? static_cast<double>(value) : 0.0;
  };
  Scan scan;
  scan.stamp_s = message.header.stamp_s;
  scan.sensor = sensor_name(topic);
  scan.angle_min_rad = message.angle_min_rad;
  scan.angle_step_rad = message.angle_step_rad;
  scan.range_min_m = positive(message.range_min_m);
  scan.range_max_m = positive(message.range_max_m);
  scan.scan_time_s = positive(message.time_step_s) * static_cast<double>(beams - 1);
  scan.ranges_m = message.ranges_m;
  return scan;
}

LogRecord record_of(Scan scan, std::size_t line) {
  LogRecord record;
  record.kind = RecordKind::scan;
  record.stamp_s = scan.stamp_s;
  record.line = line;
  record.scan = std::move(scan);
  return record;
}

}  // namespace

RobotMessages::RobotMessages(const MessageSources& sources, const LogChoice& choice)
    : sources_(sources),
      choice_(choice),
      from_transforms_(!sources.odometry_topic),
      base_frame_(choice.base_frame),
      joiner_(sources.live) {}

void RobotMessages::take(TopicRole role, const std::string& topic, const std::string& encoding,
                         std::string_view bytes) {
  ++line_;
  try {
    const MessageReader in(bytes, encoding);
    switch (role) {
      case TopicRole::none:
        break;
      case TopicRole::scan:
        read_laser_scan(in, scan_message_);
        take_scan(scan_message_, topic);
        break;
      case TopicRole::multi_echo_scan:
        read_multi_echo_scan(in, scan_message_);
        take_scan(scan_message_, topic);
        break;
      case TopicRole::cloud:
        take_cloud(read_point_cloud(in), topic, bytes, encoding);
        break;
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
    count_broken(fmt::format("{}: {}", printable(topic), broken.why));
  }
  place_scans();
}

void RobotMessages::take_scan(const LaserScanMessage& message, const std::string& topic) {
  Unplaced waiting;
  waiting.record = record_of(scan_of(message, topic), line_);
  waiting.frame = message.header.frame;
  unplaced_.push_back(std::move(waiting));
}

void RobotMessages::take_cloud(const PointCloudMessage& message, const std::string& topic,
                               std::string_view bytes, const std::string& encoding) {
  Scan scan;
  scan.stamp_s = message.header.stamp_s;
  scan.sensor = sensor_name(topic);
  Unplaced waiting;
  waiting.record = record_of(std::move(scan), line_);
  waiting.frame = message.header.frame;
  waiting.cloud = bytes;
  waiting.encoding = encoding;
  waiting_bytes_ += waiting.cloud.size();
  unplaced_.push_back(std::move(waiting));
}

void RobotMessages::take_odometry(const OdometryMessage& message) {
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

void RobotMessages::take_transforms(const std::vector<TransformMessage>& messages, bool fixed) {
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
bool RobotMessages::place(Unplaced& waiting) {
  LogRecord& record = waiting.record;
  Scan& scan = record.scan;
  RigidTransform T_base_sensor;
  // Where nothing says what moves, the LiDAR is the robot.
  const bool says_base = sources_.odometry_topic || sources_.transforms;
  const bool is_robot = choice_.without_odometry && base_frame_.empty() && !says_base;
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
        sources_.name, 0,
        fmt::format("{} is tilted by {:.0f} degrees against {}: expected a LiDAR whose scans lie in the "
                    "floor's plane "
                    "(within 5 degrees)",
                    printable(waiting.frame), mount.tilt_rad * 180.0 / kPi, printable(base_frame_)));
  scan.T_base_sensor = mount.T_base_sensor;
  scan.upside_down = mount.upside_down;
  return true;
}

void RobotMessages::take_placed(LogRecord record) {
  ++placed_;
  if (choice_.without_odometry) {
    ready_.push_back(std::move(record));
  } else {
    joiner_.add_scan(std::move(record));
  }
}

void RobotMessages::drop(std::size_t k) {
  waiting_bytes_ -= unplaced_[k].cloud.size();
  unplaced_.erase(unplaced_.begin() + static_cast<std::ptrdiff_t>(k));
}

/// A bag's in the order in which they came. On a robot a LiDAR that nobody has placed does not hold up the
/// others.
void RobotMessages::place_scans() {
  for (std::size_t k = 0; k < unplaced_.size();) {
    try {
      if (!place(unplaced_[k])) {
        if (!sources_.live) break;
        ++k;
        continue;
      }
      take_placed(std::move(unplaced_[k].record));
    } catch (const BrokenMessage& broken) {
      count_broken(broken.why);
    } catch (const Error& error) {
      if (!sources_.live) throw;
      count(error.what());
    }
    drop(k);
  }
  while (!unplaced_.empty() && waits_too_long()) {
    if (!sources_.live) throw why_unplaced();
    count(why_unplaced().what());
    drop(0);
  }
}

bool RobotMessages::waits_too_long() const {
  const bool long_ago =
      unplaced_.back().record.stamp_s > unplaced_.front().record.stamp_s + kLatestTransform_s;
  return unplaced_.size() > (sources_.live ? kMostUnplacedLive : kMostUnplaced) ||
         waiting_bytes_ > kMostWaitingBytes || (long_ago && !base_frame_.empty());
}

Error RobotMessages::no_place(const Unplaced& scan) const {
  const std::vector<std::string> frames = tree_.frames();
  const std::string known =
      frames.empty() ? "there are no transforms"
                     : fmt::format("frames: {}", printable(fmt::format("{}", fmt::join(frames, ", "))));
  const std::string sensor = printable(scan.record.scan.sensor);
  return input_error(
      sources_.name, 0,
      fmt::format(
          "no transform from {} to {} in /tf or /tf_static ({}): give the robot's frame with --base-frame, "
          "or the LiDAR's place with lidars: {}: {{x: 0, y: 0, yaw: 0}} in --config",
          printable(base_frame_), printable(scan.frame), known, sensor));
}

Error RobotMessages::no_odometry() const {
  const std::vector<std::string> frames = tree_.frames();
  if (from_transforms_)
    return input_error(
        sources_.name, 0,
        fmt::format(
            "no transform from {} to the robot in /tf (frames: {}): give --odom-frame or --odom-topic; "
            "parloc slam can do without (slam.odometry: scans)",
            choice_.odometry_frame.empty() ? "odom" : printable(choice_.odometry_frame),
            frames.empty() ? "none" : printable(fmt::format("{}", fmt::join(frames, ", ")))));
  return input_error(sources_.name, 0, "expected odometry, found a topic without a usable message");
}

Error RobotMessages::why_unplaced() const {
  const Unplaced& first = unplaced_.front();
  return base_frame_.empty() && !is_mounted(first.record.scan.sensor) ? no_odometry() : no_place(first);
}

bool RobotMessages::is_mounted(const std::string& sensor) const {
  return std::find(choice_.mounted.begin(), choice_.mounted.end(), sensor) != choice_.mounted.end();
}

/// A log has a few lines of the first troubles, a robot that drives for a day the latest of them.
void RobotMessages::count(const std::string& line) {
  constexpr std::size_t most_news = 100;
  ++counted_.broken_lines;
  if (!sources_.live)
    tell(counted_, line);
  else if (news_.size() < most_news)
    news_.push_back(line);
}

void RobotMessages::count_broken(const std::string& why) {
  count(fmt::format("{}: message {}: {}", sources_.name, line_, why));
}

bool RobotMessages::next(LogRecord& record) {
  if (!choice_.without_odometry) return joiner_.next(record);
  if (ready_.empty()) return false;
  record = std::move(ready_.front());
  ready_.pop_front();
  return true;
}

void RobotMessages::finish() {
  joiner_.finish();
  if (!unplaced_.empty()) throw why_unplaced();
}

void RobotMessages::forget() {
  tree_.forget_moving();
  unplaced_.clear();
  ready_.clear();
  waiting_bytes_ = 0;
  joiner_ = OdometryJoiner(sources_.live);
}

std::size_t RobotMessages::troubles() const {
  return counted_.broken_lines + tree_.contradictions().size() + sensor_on_.size() + joiner_.scans_before() +
         joiner_.scans_after();
}

LogWarnings RobotMessages::warnings() const {
  LogWarnings warnings = counted_;
  for (const TransformTree::Contradiction& said : tree_.contradictions())
    if (const auto sensor = sensor_on_.find(said.frame); sensor != sensor_on_.end())
      warnings.notes.push_back({LogNote::About::mount, sensor->second, said.text});
  for (std::string& line : joiner_.left_out(sources_.name)) tell(warnings, std::move(line));
  return warnings;
}

}  // namespace parloc
