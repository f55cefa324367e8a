#include "common/flow/flow_backend.h"

#include "common/error.h"

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

#if PARLOC_WITH_CUDA
std::unique_ptr<FlowBackend> make_flow_backend(BackendChoice choice, const FlowBackendConfig& config,
                                               std::string& why) {
  const bool cuda =
      choice == BackendChoice::cuda || (choice == BackendChoice::automatic && cuda_device_count() > 0);
  why = choice != BackendChoice::automatic
            ? (cuda ? "cuda, as asked" : "cpu, as asked")
            : (cuda ? "cuda: a device is there" : "cpu: no CUDA device answers");
  return cuda ? make_cuda_flow_backend(config) : make_cpu_flow_backend(config);
}
#else
std::unique_ptr<FlowBackend> make_flow_backend(BackendChoice choice, const FlowBackendConfig& config,
                                               std::string& why) {
  if (choice == BackendChoice::cuda)
    throw Error(ErrorKind::backend,
                "backend cuda is not in this build: configure with PARLOC_CUDA=ON and a CUDA toolkit, or use "
                "--backend cpu");
  why = choice == BackendChoice::cpu ? "cpu, as asked" : "cpu: this build has no CUDA backend";
  return make_cpu_flow_backend(config);
}
#endif

}  // namespace parloc
