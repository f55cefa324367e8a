// What a topic is to a robot's log.
#pragma once

namespace parloc {

/// By the type of its messages: sensor_msgs/LaserScan, MultiEchoLaserScan, PointCloud2, nav_msgs/Odometry,
/// tf2_msgs/TFMessage on /tf and on /tf_static.
enum class TopicRole { none, scan, multi_echo_scan, cloud, odometry, transforms, fixed_transforms };

}  // namespace parloc
