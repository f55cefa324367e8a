#include "common/filter/pose/covariance.h"

#include <cstddef>

namespace parloc {
namespace {

constexpr std::size_t kRosAxes[3] = {0, 1, 5};  // x, y and yaw among x, y, z, roll, pitch, yaw

}  // namespace

Covariance covariance_of(double sx, double sy, double st) {
  return {{sx * sx, 0, 0, 0, sy * sy, 0, 0, 0, st * st}};
}

Covariance covariance_from_ros(std::span<const double, 36> ros) {
  Covariance c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) c.v[3 * i + j] = ros[6 * kRosAxes[i] + kRosAxes[j]];
  return c;
}

std::array<double, 36> ros_covariance(const Covariance& c) {
  std::array<double, 36> ros{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) ros[6 * kRosAxes[i] + kRosAxes[j]] = c.v[3 * i + j];
  return ros;
}

}  // namespace parloc
