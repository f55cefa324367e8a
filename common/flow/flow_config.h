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

/// How a step in pseudo-time is made.
enum class FlowIntegrator {
  automatic,    ///< euler for edh, closed_form for the others.
  closed_form,  ///< Solved exactly for the field as it is linearised.
  euler,        ///< As published.
};
/// How pseudo-time, 0 to 1, is divided into steps.
enum class FlowSchedule {
  uniform,      ///< Evenly.
  exponential,  ///< Each `ratio` times as long as the one before.
  contract,     ///< So that each narrows the cloud by the same factor.
};
/// Where the covariance of the prior comes from (SPEC 7.10).
enum class FlowPrior { recentred, ekf, sample };
/// How the distance between the middles of cells is read.
enum class FieldInterpolation {
  bilinear,  ///< From the four cells around.
  cubic,     ///< From sixteen, by a cubic through them.
};
/// What becomes of a scan whose innovation is too large.
enum class FlowGate {
  off,      ///< It is used as any other.
  inflate,  ///< It is used, with more noise.
  reject,   ///< It is not used.
};

/// FlowConfig::steps is at most this.
constexpr int kMostFlowSteps = 100;

/// Settings of all methods; each uses those that it knows.
struct FlowConfig {
  int steps = 10;  ///< Pseudo-time steps; the field is linearised anew before each.
  FlowIntegrator integrator = FlowIntegrator::automatic;  ///< automatic: euler for edh, else closed_form.
  FlowSchedule schedule = FlowSchedule::uniform;          ///< How long its steps are.
  double ratio = 1.2;                                     ///< Of a step to the one before (exponential).
  FlowPrior prior = FlowPrior::recentred;                 ///< Whose covariance the flow starts from.
  FieldInterpolation interpolation = FieldInterpolation::bilinear;  ///< Of the distance field.
  double max_dist = 0.5;             ///< From here on a beam pulls nowhere [m].
  double sigma_range = 0.01;         ///< Standard deviation of a range [m].
  double sigma_psi_cells = 0.2;      ///< Noise floor of the mean distance [cells].
  FlowGate gate = FlowGate::off;     ///< What becomes of a scan beyond gate_nis.
  double gate_nis = 8.807468393512;  ///< Normalised innovation squared: the 99.7 % point of chi squared.
  double z_score = 0.0;              ///< Beams farther out than this are left out; 0: none.
  double map_sigma_cells = 2.0;      ///< ekf_beams: standard deviation of a wall's place [cells].
  double beta = 0.02;                ///< ekf_beams: exponent of a beam's likelihood.
  int iterations = 3;                ///< ekf_beams.
  double pfpf_sigma_xy = 0.005;      ///< pfpf: motion noise besides, so that its density exists [m].
  double pfpf_sigma_theta = 0.005;   ///< The same for the heading [rad].
};

}  // namespace parloc
