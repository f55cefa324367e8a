// A backend owns the particles, the map and the scan in its memory, and runs the stages on them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/filter/filter_group.h"
#include "common/filter/stages.h"
#include "common/map/grid_map.h"
#include "common/model/beams.h"

namespace parloc {

/// Poses and log-weights by slot, grid frame, in host memory.
struct ParticleSet {
  std::vector<float> x, y, theta, log_weight;
};

/// Settings that a step needs besides its arguments; fixed for the life of a backend.
struct FilterBackendConfig {
  std::int64_t particles = 0;  ///< The most that there can be.
  int threads = 0;             ///< CPU: 0 is all cores.
  int device = 0;              ///< CUDA: index of the device.
  SensorConfig sensor{};
  ResampleConfig resample{};
  std::int64_t min_particles =
      0;  ///< Fewer than `particles`: adapt() chooses their number. 0: it never does.
  KldConfig kld{};
  RecoveryConfig recovery{};
  std::shared_ptr<FilterGroup> group{};  ///< CUDA: steps are done with those of its other filters.

  bool adapts() const { return min_particles > 0 && min_particles < particles; }
  bool injects() const { return recovery.recovery_alpha_fast > 0.0; }
};

/// Throws Error{internal} unless the arrays are of one size that fits.
void check_upload(const ParticleSet& particles, const FilterBackendConfig& config);

/// Calls of one step come in this order: predict, [set_scan, weight, normalise_scan], estimate,
/// [adapt, resample], finish. Everything before finish() may be asynchronous; finish() is the only
/// synchronisation and brings up StepState. Nothing allocates after the first step with the largest scan. Not
/// thread-safe.
class FilterBackend {
 public:
  virtual ~FilterBackend() = default;
  virtual std::string name() const = 0;

  /// Uploads what the sensor model needs of the map. Once, before the first step.
  virtual void set_map(const GridMap& map) = 0;
  /// Table of the likelihood field, whose scale depends on the sensor's maximum range. Called when that
  /// changes.
  virtual void set_range_max(double range_max_m) = 0;
  /// As many as there are to be; at most FilterBackendConfig::particles.
  virtual void upload(const ParticleSet& particles) = 0;
  virtual ParticleSet download() const = 0;  ///< After finish().

  virtual void predict(const MotionStep& motion, RandomKey key) = 0;
  virtual void set_scan(const BeamTable& beams) = 0;
  /// Expected ranges of every particle and beam, downloaded: [N][M]. For tests and pictures, not part of a
  /// step.
  virtual std::vector<float> ray_trace() = 0;
  /// fused false: through an N x M array of expected ranges, the reference of the fused path.
  virtual void weight(bool fused) = 0;
  virtual void normalise_scan() = 0;
  virtual void estimate() = 0;
  /// Chooses how many particles resample() makes; `all`: if it makes any, as many as there can be. Nothing
  /// for a fixed number.
  virtual void adapt(RandomKey key, bool all) = 0;
  virtual void resample(RandomKey key) = 0;
  virtual StepState finish() = 0;

  /// What the last normalise_scan and resample made, after finish(); for tests. Of the particles that there
  /// were (weights, cumulative) and that there are now (ancestors; kNoAncestor where one was injected).
  virtual std::vector<std::uint64_t> weights() const = 0;
  virtual std::vector<std::uint64_t> cumulative() const = 0;
  virtual std::vector<std::uint32_t> ancestors() const = 0;
};

/// Whether a choice means CUDA in this build on this machine; `why` says the reason. Throws Error{backend}
/// for cuda in a build without it.
bool takes_cuda(BackendChoice choice, std::string& why);

/// Defined in cpu/engines.cpp and cuda/engines.cu. Throws Error{backend} if there is no usable device, or the
/// group is on another.
std::unique_ptr<FilterBackend> make_cpu_filter_backend(const FilterBackendConfig& config);
std::unique_ptr<FilterBackend> make_cuda_filter_backend(const FilterBackendConfig& config);

/// `automatic`: CUDA if built and a device answers, else CPU. An explicit choice that is not there is an
/// Error{backend}, never another one. `why` gets one line on what was taken and why.
std::unique_ptr<FilterBackend> make_filter_backend(BackendChoice choice, const FilterBackendConfig& config,
                                                   std::string& why);

/// One line per device that this build can run on, and why others cannot be used. For `parloc devices`.
std::vector<std::string> describe_devices();

/// The two halves of describe_devices, in cpu/space.cpp and cuda/space.cu; the second only in CUDA builds.
std::string describe_cpu();
std::vector<std::string> describe_cuda_devices();
/// Number of usable CUDA devices, 0 without a driver. Only in CUDA builds.
int cuda_device_count();

}  // namespace parloc
