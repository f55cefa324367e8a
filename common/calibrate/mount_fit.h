// Where a LiDAR sits, what the wheels' scales are and how late the odometry is: from how the scans moved and
// how the odometry did.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "common/calibrate/odometry_path.h"
#include "common/calibrate/scan_motions.h"

namespace parloc {

/// What is estimated, in the order of the results.
enum class Unknown { x, y, yaw, drive, turn, delay, drift, side };
inline constexpr std::size_t kUnknowns = 8;

/// One number with its standard deviation.
struct Estimate1 {
  double value = 0.0;
  double sigma = 0.0;
  bool determined = false;  ///< The drive says what it is; else `value` is what was stated.
};

struct MountFit {
  std::array<Estimate1, kUnknowns> unknown{};  ///< [m, m, rad, 1, 1, s, rad/m, 1]
  bool upside_down = false;
  bool side_known = false;  ///< Whether it turned enough to tell whether it is upside down.
  std::size_t motions = 0;  ///< That were compared,
  std::size_t unlike = 0;   ///< ... and of these, those that fit badly: slips, wrong matches.

  const Estimate1& operator[](Unknown u) const { return unknown[static_cast<std::size_t>(u)]; }
  Mount mount() const;
  OdometryScales scales() const;
  double delay_s() const { return (*this)[Unknown::delay].value; }
};

/// A number is determined where its standard deviation, by the information that all motions together hold
/// on all unknowns at once, is below this: 5 cm, 3 degrees, 3 %, 50 ms, 1 degree per metre; and only if there
/// are 12 motions at least.
double loosest_sigma(Unknown unknown);

/// Weighted least squares of the hand-eye equation, odometry (+) mount = mount (+) scan, with the odometry's
/// scales and delay (Censi et al. 2013, with poses in place of ticks). Errors are taken in the odometry, so
/// that its noise makes no scale too small. Weights: what the match of scans says of itself, and noise of the
/// odometry whose widths are found along, one for each axis and for turns and ways apart; Student's t for
/// slips. Standard deviations hold whatever the errors' distribution (sandwich), and are not below those of
/// the model. What the drive leaves open stays as `stated`. `omni`: the robot drives sideways, and that has a
/// scale of its own. `path`'s scales are changed. Deterministic on every machine.
MountFit fit_mount(const LidarMotions& lidar, OdometryPath& path, const Mount& stated, bool omni);

}  // namespace parloc
