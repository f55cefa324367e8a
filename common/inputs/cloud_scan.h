// A scan from a cloud of points: the nearest in each direction, in a band of heights.
#pragma once

#include "common/model/scan.h"
#include "common/ros/messages.h"

namespace parloc {

struct CloudBand {
  double low_m, high_m;  ///< Height above the base frame's floor.
};

/// Fills angles and ranges of `scan`, seen from the sensor's place turned upright: 720 beams of half a degree
/// from -180 degrees on, as pointcloud_to_laserscan has them; a direction without a point is inf. `mount` is
/// where the cloud's frame is in the base's. Throws BrokenMessage for a cloud without x, y, z of float32 or
/// float64, or shorter than it says.
void scan_from_cloud(const PointCloudMessage& cloud, const RigidTransform& T_base_sensor,
                     const CloudBand& band, Scan& scan);

}  // namespace parloc
