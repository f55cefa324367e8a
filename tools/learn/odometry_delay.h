// How much later than the scans a log's odometry comes: motion.odometry_delay_s, from a log with known poses.
#pragma once

#include <cstddef>
#include <optional>

#include "common/model/trajectory.h"

namespace parloc::tools {

struct OdometryDelay {
  static constexpr double kLeast_s = 0.01;  ///< Less changes nothing that could be seen.

  double delay_s = 0.0;   ///< What is stamped t was true at t minus this.
  double sigma_s = 0.0;   ///< Its standard error.
  std::size_t turns = 0;  ///< Compared, of one reading to the next.

  /// Beyond three standard errors and kLeast_s: worth a setting.
  bool significant() const;
};

/// Compares how the robot turns by the odometry, from reading to reading, with how it turns by the poses
/// `delay_s` earlier, by least squares over -0.3 to 0.3 s. A wrong scale of the odometry is allowed for, and
/// readings that do not fit at all (slips, jumps) are left out. `odometry` is what the scans carry, in the
/// log's order and any frame; `poses` is as dense as the scans. Where either has more than 0.6 s between two,
/// that part is left out. Nothing where turns are too few or too alike to tell. Deterministic.
std::optional<OdometryDelay> estimate_odometry_delay(const Trajectory& odometry, const Trajectory& poses);

}  // namespace parloc::tools
