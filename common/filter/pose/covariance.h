// A pose with how sure it is, and its covariance as ROS writes it.
#pragma once

#include <array>
#include <span>

#include "common/math/pose.h"

namespace parloc {

/// 3x3 covariance of (x, y, theta), row-major, symmetric [m^2, m rad, rad^2].
struct Covariance {
  double v[9] = {};  ///< Row by row.
};

/// A weighted mean with circular heading, and its covariance, in the map frame.
struct PoseEstimate {
  Pose mean;              ///< In the map frame; the heading is the direction of the mean unit vector.
  Covariance covariance;  ///< About it.
  double weight = 0.0;    ///< Share of the total weight, 0 to 1.
  double heading_resultant = 0.0;  ///< R of the circular mean: 1 is certain, 0 undefined.
};

/// Of three errors that have nothing to do with each other: their standard deviations.
Covariance covariance_of(double sigma_x_m, double sigma_y_m, double sigma_theta_rad);

/// From geometry_msgs/PoseWithCovariance: row-major 6x6 of (x, y, z, roll, pitch, yaw), of which x, y and yaw
/// are read. Takes a double[36] as well as a std::array.
Covariance covariance_from_ros(std::span<const double, 36> covariance);
/// The same the other way; what is about z, roll and pitch is 0.
std::array<double, 36> ros_covariance(const Covariance& covariance);

}  // namespace parloc
