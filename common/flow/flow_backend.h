// A backend owns the particles, the distance field and the scan in its memory, and runs the steps of a flow
// or Kalman filter on them (common/flow/flow_stages.h).
#pragma once

#include <memory>
#include <string>

#include "common/filter/filter_backend.h"
#include "common/flow/flow_state.h"

namespace parloc {

/// Fixed for the life of a backend, but for what the map adds to the rules.
struct FlowBackendConfig {
  std::int64_t particles = 0;  ///< None for Kalman filters.
  int threads = 0;             ///< CPU: 0 is all cores.
  int device = 0;              ///< CUDA: index of the device.
  FlowConfig flow;
  FlowMethod method = FlowMethod::naedh;
  ResampleConfig resample;  ///< pfpf
};

/// Nothing allocates after the first step with the largest scan. Not thread-safe.
class FlowBackend {
 public:
  virtual ~FlowBackend() = default;
  virtual std::string name() const = 0;
  /// Once, before the first step.
  virtual void set_map(const GridMap& map) = 0;
  /// Grid frame. As many particles as configured.
  virtual void start(const ParticleSet& particles, const PoseGaussian& gaussian) = 0;
  virtual ParticleSet download() const = 0;
  /// Moves everything by odometry and takes the scan in, if there is one. What is returned holds until the
  /// next step.
  virtual const FlowState& step(const MotionStep& motion, RandomKey key, const BeamTable* scan) = 0;
  /// Of the last step, pfpf: effective number of particles before resampling, and whether that happened.
  virtual const StepState& weights_state() const = 0;
};

/// The rules of a configuration on a map.
FlowRules bind_flow_rules(const FlowConfig& config, FlowMethod method, double resolution_m);

/// Defined in cpu/engines.cpp and cuda/engines.cu. Throw as make_cpu_filter_backend and
/// make_cuda_filter_backend.
std::unique_ptr<FlowBackend> make_cpu_flow_backend(const FlowBackendConfig& config);
std::unique_ptr<FlowBackend> make_cuda_flow_backend(const FlowBackendConfig& config);
/// As make_filter_backend.
std::unique_ptr<FlowBackend> make_flow_backend(BackendChoice choice, const FlowBackendConfig& config,
                                               std::string& why);

}  // namespace parloc
