// What a localizer says to a robot, as ROS 2 messages.
#pragma once

#include <string>

#include "common/live/live_localizer.h"
#include "common/ros/message_writer.h"

namespace parloc {

/// The names of frames that messages carry.
struct LiveFrames {
  std::string map = "map", odom = "odom";
};

/// geometry_msgs/PoseWithCovarianceStamped in the map's frame, at the scan's stamp.
MessageWriter pose_message(const LiveAnswer& answer, const LiveFrames& frames);
/// tf2_msgs/TFMessage with the transform from map to odom. Dated ahead by `tolerance_s`, so that it serves
/// until the next one, as nav2's.
MessageWriter map_odom_message(const LiveAnswer& answer, const LiveFrames& frames, double tolerance_s);
/// nav2_msgs/ParticleCloud of at most `most` particles, at the answer's stamp.
MessageWriter particles_message(const LiveAnswer& answer, const LiveFrames& frames,
                                const Localizer& localizer, std::size_t most);
/// diagnostic_msgs/DiagnosticArray: state, probability, hypotheses, particles, and what was skipped.
MessageWriter diagnostics_message(const LiveAnswer& answer, const LiveFrames& frames,
                                  const std::string& name);

}  // namespace parloc
