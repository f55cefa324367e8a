// Settings of the odometry motion model.
#pragma once

namespace parloc {

/// How noise grows with motion.
enum class MotionForm {
  seed,   ///< Standard deviations linear in the size of the motion (Paz et al. 2012).
  thrun,  ///< Variances quadratic in it (Thrun et al. 2005; AMCL).
  omni,   ///< Likewise, and the robot drives sideways.
};
/// Odometry motion model (SPEC 1; Paz et al. 2012 eq. 6 to 8), and what a robot cannot do: what the odometry
/// says beyond that is a fault of the odometry.
struct MotionConfig {
  MotionForm form = MotionForm::seed;  ///< How noise grows.
  double alpha1 = 0.2;                 ///< Rotation noise from rotation [1].
  double alpha2 = 0.1;                 ///< Rotation noise from translation [rad/m].
  double alpha3 = 0.2;                 ///< Translation noise from translation [1].
  double alpha4 = 0.1;                 ///< Translation noise from rotation [m/rad].
  double alpha5 = 0.2;                 ///< omni: sideways noise from translation [1].
  double sigma_rot_min_rad = 0.0;      ///< Noise floor of each rotation, only while the robot moves.
  double sigma_trans_min_m = 0.0;      ///< Noise floor of the translation, only while the robot moves.
  double sigma_rot_per_s = 0.005;      ///< Noise besides, whether it moves or stands [rad/sqrt(s)].
  double sigma_trans_per_s = 0.005;    ///< Likewise along its heading [m/sqrt(s)].
  /// Share of the particles that move as if the wheels had slipped, with noise of these widths besides: the
  /// heavy tail.
  double slip_share = 0.0;
  double slip_sigma_m = 0.3;            ///< Noise of a slip along x, and along y.
  double slip_sigma_rad = 0.2;          ///< And of the heading.
  double min_translation_m = 0.01;      ///< Below it a step is a turn in place (SPEC 1.1).
  bool symmetric = true;                ///< Driving backwards is not a turn by pi.
  double max_speed_mps = 10.0;          ///< A step that is faster is a jump of the odometry, no motion,
  double max_acceleration_mps2 = 10.0;  ///< as is one that gets faster than this since the steps before,
  double max_turn_rate_rad_s = 12.0;    ///< or one that turns faster.
  double max_jump_m = 1.0;              ///< Where stamps stand still: a longer step is a jump.
  /// How much later than the scans the odometry comes: what is stamped t was true at t minus this.
  double odometry_delay_s = 0.0;
  double odometry_scale_drive = 1.0;  ///< What its motion along the heading times this is, is true.
  double odometry_scale_turn = 1.0;   ///< Likewise of turns.
  double odometry_scale_side = 1.0;   ///< omni: likewise to the side.
};

}  // namespace parloc
