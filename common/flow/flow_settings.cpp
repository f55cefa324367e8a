#include "common/flow/flow_settings.h"

#include <limits>

#include "common/filter/filter_settings.h"
#include "common/flow/flow_filter_config.h"
#include "common/model/model_settings.h"

namespace parloc {
namespace {

const std::vector<Choice<FlowIntegrator>> kFlowIntegrators{{"auto", FlowIntegrator::automatic},
                                                           {"closed_form", FlowIntegrator::closed_form},
                                                           {"euler", FlowIntegrator::euler}};
const std::vector<Choice<FlowSchedule>> kFlowSchedules{{"uniform", FlowSchedule::uniform},
                                                       {"exponential", FlowSchedule::exponential},
                                                       {"contract", FlowSchedule::contract}};
const std::vector<Choice<FlowPrior>> kFlowPriors{
    {"recentred", FlowPrior::recentred}, {"ekf", FlowPrior::ekf}, {"sample", FlowPrior::sample}};
const std::vector<Choice<FieldInterpolation>> kFieldInterpolations{{"bilinear", FieldInterpolation::bilinear},
                                                                   {"cubic", FieldInterpolation::cubic}};
const std::vector<Choice<FlowGate>> kFlowGates{
    {"off", FlowGate::off}, {"inflate", FlowGate::inflate}, {"reject", FlowGate::reject}};

}  // namespace

void add_flow_settings(Settings& s, FlowConfig& flow, int& max_beams) {
  s.group(
      "flow",
      "Kalman filters and particle flows on the distance field (docs/flow.md); the others do not read it.");
  s.add("max_beams", "Beams used of a scan, in place of scan.max_beams", max_beams, {1, 4096});
  s.add("steps", "Pseudo-time steps; the field is linearised anew before each", flow.steps,
        {1, kMostFlowSteps});
  s.add("integrator", "Of a step; auto: euler for edh, else closed_form (naedh: always)", flow.integrator,
        kFlowIntegrators);
  s.add("schedule", "Equal steps, steps that grow by ratio, or of equal contraction", flow.schedule,
        kFlowSchedules);
  s.add("ratio", "Of an exponential step to the one before", flow.ratio, {0.1, 10});
  s.add("prior", "Covariance: recursion about the particles' mean, an EKF's, or theirs", flow.prior,
        kFlowPriors);
  s.add("interpolation", "Of the distance field between cells", flow.interpolation, kFieldInterpolations);
  s.add("max_dist", "From here on a beam's end pulls nowhere [m]", flow.max_dist, {0, 100, true});
  s.add("sigma_range", "Standard deviation of a range [m]", flow.sigma_range, {0, 10});
  s.add("sigma_psi_cells", "Noise floor of a scan's mean distance [cells]; 0: as published",
        flow.sigma_psi_cells, {0, 100});
  s.add("gate", "What becomes of a scan beyond gate_nis: nothing, more noise, or not used", flow.gate,
        kFlowGates);
  s.add("gate_nis", "Innovation squared over its variance", flow.gate_nis, {0, 1e6, true});
  s.add("z_score", "Leave out beams whose distance is farther out than this; 0: none", flow.z_score,
        {0, 1000});
  s.add("map_sigma_cells", "ekf_beams: standard deviation of a wall's place [cells]", flow.map_sigma_cells,
        {0.01, 100});
  s.add("beta", "ekf_beams: exponent of a beam's likelihood", flow.beta, {0, 1, true});
  s.add("iterations", "ekf_beams: at most", flow.iterations, {1, 100});
  s.add("pfpf_sigma_xy", "pfpf: motion noise besides, whatever the motion [m]", flow.pfpf_sigma_xy,
        {0.0001, 10});
  s.add("pfpf_sigma_theta", "... of the heading [rad]", flow.pfpf_sigma_theta, {0.0001, 10});
}

void validate(const FlowFilterConfig& config) {
  FlowFilterConfig copy = config;
  Settings settings;
  settings.add("particles", "Number of particles", copy.particles, {1, 16'777'216});
  add_settings(settings, static_cast<ComputeConfig&>(copy));
  add_settings(settings, copy.motion);
  add_settings(settings, copy.scan);
  add_settings(settings, copy.resample);
  add_flow_settings(settings, copy.flow, copy.scan.max_beams);
  require_none(first_beyond_limits(settings));
  require_none(broken_rule(config));
}

}  // namespace parloc
