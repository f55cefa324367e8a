// What is read of a log that has more than one of a kind: a bag with several LiDARs, say.
#pragma once

#include <string>
#include <vector>

namespace parloc {

/// Names of topics and frames may lack their slash. CARMEN logs have no use for any of it.
struct LogChoice {
  std::string scan_topic;  ///< Several, with commas between: several LiDARs. Empty: the only one there is.
  std::string odometry_topic;  ///< Empty: the only one there is, else transforms.
  std::string odometry_frame;  ///< Whose transforms are the odometry, if no topic is. Empty: "odom".
  std::string base_frame;      ///< Whose pose is estimated. Empty: the odometry's child frame.
  std::string map_topic;       ///< Empty: the only one there is.
  std::string truth_topic;     ///< Poses; empty: the only topic of them there is.
  std::string truth_frame;     ///< True poses are where the base is in it, by /tf. Empty: those of the topic.
  double cloud_low = 0.1;      ///< What of a cloud of points is a scan: from this height over the base [m],
  double cloud_high = 1.0;     ///< to this one.
  std::vector<std::string> mounted{};  ///< Sensors whose place on the robot is known without the log.
  bool without_odometry = false;       ///< Scans alone will do: where there is no odometry, it is zero.
};

}  // namespace parloc
