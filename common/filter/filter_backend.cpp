#include "common/filter/filter_backend.h"

#include "common/error.h"

namespace parloc {

void check_upload(const ParticleSet& p, const FilterBackendConfig& config) {
  const std::size_t n = p.x.size();
  if (n < 1 || n > static_cast<std::size_t>(config.particles) || p.y.size() != n || p.theta.size() != n ||
      p.log_weight.size() != n)
    throw Error(ErrorKind::internal, "FilterBackend::upload: expected 1 to " +
                                         std::to_string(config.particles) + " particles, got " +
                                         std::to_string(n));
}

#if PARLOC_WITH_CUDA
bool takes_cuda(BackendChoice choice, std::string& why) {
  const bool cuda =
      choice == BackendChoice::cuda || (choice == BackendChoice::automatic && cuda_device_count() > 0);
  why = choice != BackendChoice::automatic
            ? (cuda ? "cuda, as asked" : "cpu, as asked")
            : (cuda ? "cuda: a device is there" : "cpu: no CUDA device answers");
  return cuda;
}

std::vector<std::string> describe_devices() {
  std::vector<std::string> lines = {describe_cpu()};
  for (const std::string& line : describe_cuda_devices()) lines.push_back(line);
  return lines;
}
#else
bool takes_cuda(BackendChoice choice, std::string& why) {
  if (choice == BackendChoice::cuda)
    throw Error(ErrorKind::backend,
                "backend cuda is not in this build: configure with PARLOC_CUDA=ON and a CUDA toolkit, or use "
                "--backend cpu");
  why = choice == BackendChoice::cpu ? "cpu, as asked" : "cpu: this build has no CUDA backend";
  return false;
}

std::vector<std::string> describe_devices() {
  return {describe_cpu(), "cuda: not in this build (PARLOC_CUDA=OFF)"};
}
#endif

std::shared_ptr<FilterGroup> make_filter_group(const ComputeConfig& compute) {
  std::string why;
  if (takes_cuda(compute.backend, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_filter_group(compute.device);
  }
  return nullptr;
}

std::unique_ptr<FilterBackend> make_filter_backend(BackendChoice choice, const FilterBackendConfig& config,
                                                   std::string& why) {
  if (takes_cuda(choice, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_filter_backend(config);
  }
  return make_cpu_filter_backend(config);
}

}  // namespace parloc
