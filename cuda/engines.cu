// The engines on CUDA; compiled as C++, those that run the kernels on the host for the tests.
#include "common/filter/engine/filter_engine.h"
#include "common/flow/flow_engine.h"
#include "common/slam/engine/slam_engine.h"
#include "cuda/space.h"

namespace parloc {

#if defined(__CUDACC__)
std::shared_ptr<FilterGroup> make_cuda_filter_group(int device) {
  return std::make_shared<cuda::StepGroup>(device);
}
std::unique_ptr<FilterBackend> make_cuda_filter_backend(const FilterBackendConfig& config) {
  return std::make_unique<FilterEngine<cuda::Space>>(config);
}
std::unique_ptr<FlowBackend> make_cuda_flow_backend(const FlowBackendConfig& config) {
  return std::make_unique<FlowEngine<cuda::Space>>(config);
}
std::unique_ptr<SlamBackend> make_cuda_slam_backend(const SlamBackendConfig& config) {
  return std::make_unique<SlamEngine<cuda::Space>>(config);
}
#else
namespace cuda_on_host {
std::shared_ptr<FilterGroup> make_filter_group_on_host() {
  return std::make_shared<StepGroup>(0);
}
std::unique_ptr<FilterBackend> make_filter_backend_on_host(const FilterBackendConfig& config) {
  return std::make_unique<FilterEngine<Space>>(config);
}
std::unique_ptr<FlowBackend> make_flow_backend_on_host(const FlowBackendConfig& config) {
  return std::make_unique<FlowEngine<Space>>(config);
}
std::unique_ptr<SlamBackend> make_slam_backend_on_host(const SlamBackendConfig& config) {
  return std::make_unique<SlamEngine<Space>>(config);
}
}  // namespace cuda_on_host
#endif

}  // namespace parloc
