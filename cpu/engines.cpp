// The engines on OpenMP.
#include "common/filter/engine/filter_engine.h"
#include "common/flow/flow_engine.h"
#include "common/slam/engine/slam_engine.h"
#include "cpu/space.h"

namespace parloc {

std::unique_ptr<FilterBackend> make_cpu_filter_backend(const FilterBackendConfig& config) {
  return std::make_unique<FilterEngine<cpu::Space>>(config);
}
std::unique_ptr<FlowBackend> make_cpu_flow_backend(const FlowBackendConfig& config) {
  return std::make_unique<FlowEngine<cpu::Space>>(config);
}
std::unique_ptr<SlamBackend> make_cpu_slam_backend(const SlamBackendConfig& config) {
  return std::make_unique<SlamEngine<cpu::Space>>(config);
}

}  // namespace parloc
