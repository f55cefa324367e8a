// Odometry made worse in the ways in which real robots' odometry is worse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/io/log.h"

namespace parloc {

/// Rates are per minute of the log's time. What is 0 (or 1, for scales) does not happen.
struct OdometryCorruption {
  enum class Slip { both, rotation, translation };

  double noise_translation = 0.0;     ///< Gaussian [m per root metre].
  double noise_rotation = 0.0;        ///< [rad per root radian turned].
  double noise_rotation_per_m = 0.0;  ///< [rad per root metre].
  double scale_translation = 1.0, scale_rotation = 1.0;
  double drift_rad_per_m = 0.0;       ///< Of the heading, as the robot drives.
  double gyro_drift_rad_per_s = 0.0;  ///< Of the heading, as it stands.
  /// Within one scan step the wheels report so much too much or too little.
  double slips_per_min = 0.0;
  Slip slip_kind = Slip::both;
  bool slip_standing = false;  ///< Also at steps without motion.
  /// From then on the wheels report nothing, until so much motion is hidden: pushed, or wheels in the air.
  double hidden_per_min = 0.0;
  double least_slip_rad = 0.08726646259971647, most_slip_rad = 0.26179938779914941;  ///< 5 to 15 degrees.
  double least_slip_m = 0.1, most_slip_m = 0.3;
  double resets_per_min = 0.0;  ///< The odometry starts again at its origin.
  double offset_s = 0.0;        ///< A scan carries the odometry of so much earlier; later if negative.
  int keep_every = 1;           ///< Of the scans, applied last; odometry between them stays.
};

/// Of a hiding two, once it is over: how much was turned and driven meanwhile.
struct CorruptionEvent {
  enum class Kind { slip_rotation, slip_translation, hidden_rotation, hidden_translation, reset };
  double stamp_s = 0.0;
  Kind kind = Kind::reset;
  double value = 0.0;  ///< [rad] or [m]; signed, but hidden translation.
};

/// Corrupts the motion from record to record, in the robot's frame, and chains it anew from the first pose:
/// scans, stamps and order stay. Random numbers are Philox's, with a stream for each kind, so that one kind
/// does not move the events of another; equal records, corruptions and seeds give equal odometry on every
/// machine. Returns what happened, in time.
std::vector<CorruptionEvent> corrupt_odometry(std::vector<LogRecord>& records, const OdometryCorruption& c,
                                              std::uint64_t seed);

/// "hide=3,slip_deg=8:20,slip_m=0.2:0.5" with the keys noise_trans, noise_rot, noise_rot_per_m, scale_trans,
/// scale_rot, drift (degrees per metre), gyro_drift (degrees per minute), slips, slip_kind (both, rotation,
/// translation), slip_deg (from:to), slip_m (from:to), hide, resets, offset_ms and thin. Throws Error{usage}
/// for an unknown key (naming the nearest one), a key that comes twice, or a value outside its limits.
OdometryCorruption corruption_from_text(const std::string& text);

}  // namespace parloc
