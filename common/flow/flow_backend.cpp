#include "common/flow/flow_backend.h"

namespace parloc {

FlowRules bind_flow_rules(const FlowConfig& c, FlowMethod method, double resolution_m) {
  const bool automatic = c.integrator == FlowIntegrator::automatic;
  const double sigma_psi_m = c.sigma_psi_cells * resolution_m, range_cells = c.sigma_range / resolution_m;
  FlowRules r;
  r.method = method;
  r.euler = method == FlowMethod::edh && automatic ? true : c.integrator == FlowIntegrator::euler;
  if (method == FlowMethod::naedh) r.euler = false;
  r.prior = c.prior;
  r.interpolation = c.interpolation;
  r.times = flow_times(c.schedule, c.steps, c.ratio);
  r.cap_cells = static_cast<float>(c.max_dist / resolution_m);
  r.resolution_m = resolution_m;
  r.noise = {c.sigma_range * c.sigma_range, sigma_psi_m * sigma_psi_m};
  r.gate = {c.gate, c.gate_nis};
  r.z_score = c.z_score;
  r.information = {static_cast<float>(range_cells * range_cells),
                   static_cast<float>(c.map_sigma_cells * c.map_sigma_cells), static_cast<float>(c.beta)};
  r.iterations = c.iterations;
  r.pfpf_sigma_xy = static_cast<float>(c.pfpf_sigma_xy);
  r.pfpf_sigma_theta = static_cast<float>(c.pfpf_sigma_theta);
  return r;
}

std::unique_ptr<FlowBackend> make_flow_backend(BackendChoice choice, const FlowBackendConfig& config,
                                               std::string& why) {
  if (takes_cuda(choice, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_flow_backend(config);
  }
  return make_cpu_flow_backend(config);
}

}  // namespace parloc
