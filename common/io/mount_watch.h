// Whether a LiDAR's place on the robot stays what it was.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/math/pose.h"

namespace parloc {

/// A LiDAR that is bolted on does not move: where a log's poses of it say so, they are wrong (a converter's
/// zeros, poses of another frame), or it sits on a joint. Both are worth a line.
class MountWatch {
 public:
  /// Farther than this from its first place the mount has moved: beyond what rounded poses, or a robot's pose
  /// taken a few hundredths of a second beside the laser's, can make of it.
  static constexpr double kMoved_m = 0.2;
  static constexpr double kTurned_rad = 0.2;

  /// To be called with every scan, in order; says so of the first that is farther off, once per LiDAR.
  std::optional<LogNote> look(const LogRecord& scan);

 private:
  struct Lidar {
    std::string name;
    Pose first;
    bool told = false;
  };
  std::vector<Lidar> lidars_;
};

}  // namespace parloc
