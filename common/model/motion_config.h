// Settings of the odometry motion model.
#pragma once

namespace parloc {

enum class MotionForm { seed, thrun };
/// Odometry motion model (SPEC 1; Paz et al. 2012 eq. 6 to 8).
struct MotionConfig {
  MotionForm form = MotionForm::seed;  ///< seed: sigma linear in |delta|; thrun: variance quadratic.
  double alpha1 = 0.2;                 ///< Rotation noise from rotation [1].
  double alpha2 = 0.1;                 ///< Rotation noise from translation [rad/m].
  double alpha3 = 0.2;                 ///< Translation noise from translation [1].
  double alpha4 = 0.1;                 ///< Translation noise from rotation [m/rad].
  double sigma_rot_min_rad = 0.0;      ///< Noise floor of each rotation, only while the robot moves.
  double sigma_trans_min_m = 0.0;      ///< Noise floor of the translation, only while the robot moves.
  double min_translation_m = 0.01;     ///< Below it a step is a turn in place (SPEC 1.1).
  bool symmetric = true;               ///< Driving backwards is not a turn by pi.
  double max_jump_m = 1.0;             ///< A longer odometry step is reported and its noise inflated.
};

}  // namespace parloc
