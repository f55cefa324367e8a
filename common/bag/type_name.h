// One name for a message type, whichever ROS wrote it.
#pragma once

#include <string>
#include <string_view>

namespace parloc {

/// "sensor_msgs/msg/LaserScan" (ROS 2), "sensor_msgs::msg::dds_::LaserScan_" (DDS): "sensor_msgs/LaserScan".
/// Others as they are.
inline std::string type_name(std::string_view name) {
  std::string out(name);
  const auto replace = [&](std::string_view from, std::string_view to) {
    const std::size_t at = out.find(from);
    if (at != std::string::npos) out.replace(at, from.size(), to);
  };
  if (out.find("::msg::dds_::") != std::string::npos) {
    replace("::msg::dds_::", "/");
    if (out.ends_with('_')) out.pop_back();
  }
  replace("/msg/", "/");
  return out;
}

}  // namespace parloc
