// The definitions of the ROS 2 messages that parloc writes, as files carry them.
#pragma once

#include <string>

namespace parloc {

/// Of a type such as "sensor_msgs/msg/LaserScan": its fields (ros2msg), and those of each type within, in the
/// form that MCAP has for them. Throws Error{internal} for a type that is not in the list.
std::string message_definition(const std::string& type);

}  // namespace parloc
