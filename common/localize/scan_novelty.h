// How much of what a scan says is new: two scans from one spot see the same things, and err alike.
#pragma once

#include <optional>

#include "common/math/pose.h"
#include "common/model/beams.h"

namespace parloc {

/// Counts a drive in scans that are independent, however often the LiDAR turns and whatever its clock says.
class ScanNovelty {
 public:
  void clear() { *this = {}; }

  /// Share of the scan that is new since the one before, 0 to 1: 1 where the robot has moved a twentieth of
  /// what it sees, or turned 0.2 rad, or where two seconds have passed, in which people move. The first is
  /// new.
  double add(const Pose& odometry, double elapsed_s, const BeamTable& beams);

 private:
  std::optional<Pose> before_;
};

}  // namespace parloc
