// A backend with map, particles and scan, on which filter steps can be timed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "common/filter/filter_backend.h"
#include "common/model/beams.h"
#include "common/model/motion.h"
#include "tools/bench/steps/scenes.h"
#include "tools/bench/steps/variants.h"

namespace parloc::tools::bench {

/// The parts of a step, in order. `scan` is the choice of the beams and their upload.
inline constexpr std::array<const char*, 6> kStageNames{"predict",        "scan",     "weight",
                                                        "normalise_scan", "estimate", "resample"};
using StageSeconds = std::array<double, kStageNames.size()>;

/// What each stage must read and write at least, in bytes: every array of particles that it needs once. The
/// map and whatever a stage does besides is not in it.
std::array<double, kStageNames.size()> least_stage_bytes(std::int64_t particles, int beams);

/// Every step starts from the same particles with new random numbers: they are restored outside the clock, so
/// that all steps do the same work, and branch predictors cannot learn it by heart. Throws parloc::Error.
class Rig {
 public:
  Rig(const Variant& variant, const Scene& scene, Cloud cloud, std::int64_t particles);

  void use_beams(int beams);
  /// Seconds of one step, from the odometry and the raw scan on the host to the estimate on the host: motion
  /// model, choice and upload of the beams, all six stages, download of the estimate.
  double step_seconds();
  /// The same step with a wait after every stage, which makes it a little longer on a device.
  StageSeconds stage_seconds();

  std::string backend_name() const { return backend_->name(); }
  const StepState& last() const { return last_; }  ///< Of the last step.

 private:
  void restore();
  void select();
  MotionStep motion() const;

  SensorConfig sensor_;
  double resolution_m_;
  const Scene* scene_;
  ParticleSet cloud_;
  Scan scan_;
  ScanConfig scan_config_;
  BeamTable beams_;
  BeamCounts counts_;
  std::unique_ptr<FilterBackend> backend_;
  StepState last_;
  std::uint32_t step_ = 0;
};

}  // namespace parloc::tools::bench
