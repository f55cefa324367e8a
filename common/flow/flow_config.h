// Settings of the filters on the distance field: particle flows and Kalman filters.
#pragma once

namespace parloc {

/// Who filters. The first two have no particles; docs/flow.md says which is for what.
enum class FlowMethod {
  ekf,        ///< One innovation per scan: the mean distance of its end points to the walls.
  ekf_beams,  ///< One per beam, iterated.
  edh,        ///< Exact flow, linearised at the mean, in Euler steps as published.
  naedh,      ///< The same flow, each step solved in closed form.
  ledh,       ///< Linearised at every particle.
  gromov,     ///< Stochastic flow, linearised at the mean.
  pfpf,       ///< Particle filter whose proposal is the local flow, with weights.
};

enum class FlowIntegrator { automatic, closed_form, euler };
enum class FlowSchedule { uniform, exponential, contract };
/// Where the covariance of the prior comes from (SPEC 7.10).
enum class FlowPrior { recentred, ekf, sample };
enum class FieldInterpolation { bilinear, cubic };
enum class FlowGate { off, inflate, reject };

constexpr int kMostFlowSteps = 100;

struct FlowConfig {
  int steps = 10;  ///< Pseudo-time steps; the field is linearised anew before each.
  FlowIntegrator integrator = FlowIntegrator::automatic;  ///< automatic: euler for edh, else closed_form.
  FlowSchedule schedule = FlowSchedule::uniform;
  double ratio = 1.2;  ///< Of a step to the one before (exponential).
  FlowPrior prior = FlowPrior::recentred;
  FieldInterpolation interpolation = FieldInterpolation::bilinear;
  double max_dist = 0.5;         ///< From here on a beam pulls nowhere [m].
  double sigma_range = 0.01;     ///< Standard deviation of a range [m].
  double sigma_psi_cells = 0.2;  ///< Noise floor of the mean distance [cells].
  FlowGate gate = FlowGate::off;
  double gate_nis = 8.807468393512;  ///< Normalised innovation squared: the 99.7 % point of chi squared.
  double z_score = 0.0;              ///< Beams farther out than this are left out; 0: none.
  double map_sigma_cells = 2.0;      ///< ekf_beams: standard deviation of a wall's place [cells].
  double beta = 0.02;                ///< ekf_beams: exponent of a beam's likelihood.
  int iterations = 3;                ///< ekf_beams.
  double pfpf_sigma_xy = 0.005;      ///< pfpf: motion noise besides, so that its density exists [m].
  double pfpf_sigma_theta = 0.005;   ///< The same for the heading [rad].
};

}  // namespace parloc
