// Mapping that is fed with a robot's messages, as they come.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/inputs/topic_role.h"
#include "common/map/grid_map.h"
#include "common/slam/grid_slam.h"

namespace parloc {

/// What is said to one scan.
struct LiveSlamAnswer {
  double stamp_s = 0.0;   ///< The scan's.
  Pose pose;              ///< T_map_base, by the most likely particle.
  Pose T_map_odom;        ///< What takes the robot's own odometry to the map.
  bool taken_in = false;  ///< The robot had moved far enough for the scan to count.
};

/// Messages go in, poses and a map come out: the same as `parloc slam` makes of a bag of the same messages,
/// but that loops are closed at the end alone. Nothing that a message can hold throws. Not thread-safe.
class LiveSlam {
 public:
  /// Frames and LiDARs as LiveLocalizer has them. Throws as GridSlam.
  explicit LiveSlam(const Config& config, bool odometry_topic = false);
  ~LiveSlam();
  LiveSlam(LiveSlam&&) noexcept;
  LiveSlam& operator=(LiveSlam&&) noexcept;

  /// A message in CDR, as ROS 2 sends it.
  void take(TopicRole role, const std::string& topic, std::string_view bytes);
  /// The answer to the next scan that can be given one; nothing: more has to be taken first.
  std::optional<LiveSlamAnswer> next();
  /// The robot's clock was set: what was taken is forgotten, map and pose stay.
  void forget();

  /// The most likely particle's map so far; nothing before the first scan. Its cost grows with its area.
  std::optional<GridMap> map_so_far() const;
  const GridSlam& slam() const;  ///< With everything that it tells.
  std::size_t waiting() const;   ///< Scans without an answer yet.
  /// Each once, as it is seen.
  std::vector<std::string> troubles();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
