// What every filter that tracks a pose keeps of its run.
#pragma once

#include <optional>
#include <string>

#include "common/filter/filter_backend.h"
#include "common/filter/pose_filter.h"
#include "common/filter/steps/step_front_end.h"
#include "common/math/sha256.h"

namespace parloc {

/// The settings of a run, to be the first of its bases: the other refers to them.
template <class Config>
struct RunConfig {
  Config config;
};

struct PoseFilter::Run {
  /// `step_config` outlives this.
  Run(StepConfig& step_config, const GridMap& on) : settings(step_config), map(on), front_end(step_config) {}
  virtual ~Run() = default;
  /// The particles by slot, grid frame.
  virtual ParticleSet download() const = 0;
  virtual std::string backend_name() const = 0;

  RandomKey key() const { return {settings.seed, static_cast<std::uint32_t>(steps)}; }
  /// After the particles were put where they start.
  void begin();
  /// Throws Error{usage} unless there was a start.
  void expect_started() const;
  /// What every step begins with: the odometry at the scan's stamp; nothing if the scan is not to be taken,
  /// and why_skipped says why. Throws as PoseFilter::step.
  std::optional<OdometryReading> take(const Pose& recorded, const Scan& scan);
  /// At the end of a step; `chosen` is what it says of the pose.
  void remember(const Estimate& e, const PoseEstimate& chosen);
  /// The last estimate, to be given out again: no scan was used for it.
  Estimate not_weighed() const;

  StepConfig& settings;
  GridMap map;
  StepFrontEnd front_end;
  BeamTable beams;  ///< Of the last scan that was taken in.
  Estimate last;
  PoseEstimate given;             ///< The last pose that was given out, ...
  std::optional<double> given_s;  ///< ... and its time; none before the first.
  std::string why_skipped;
  std::size_t steps = 0;
  bool started = false;
  Sha256 estimates;  ///< Of all steps.
};

}  // namespace parloc
