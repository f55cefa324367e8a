// THE STAGE CONTRACT. The stages exist under the same names in cpu/ (OpenMP) and cuda/ (kernels); both
// are only loops over the functions in common/, so that every array below holds the same bits on both.
//
// Frame and units: particles live in the grid frame of the map (origin at its lower-left corner), float32
// metres and radians, so that coordinates stay small. Angles in [-pi, pi). N particles (1 to 2^24), M beams
// (0 to 4096). Storage slots never move; slot i is also the random counter of particle i. N may change from
// step to step, up to a fixed capacity: it lies in memory beside the poses, and a slot at or beyond it
// influences nothing. Memory: every pointer is in the backend's space. The caller owns it; no stage
// allocates. A step may be recorded and started again: what changes from step to step (motion, random key,
// shape of the scan) a stage reads from the StepInput when it runs, never from its arguments. Failure: stages
// do not fail on data. NaN log-weights count as -inf; if all are -inf, the weights become uniform and
// `degenerate` is set. A failing device throws Error{internal}.
//
// clang-format off
// | stage          | reads                                    | writes                                              |
// |----------------|------------------------------------------|-----------------------------------------------------|
// | predict        | poses, motion                            | poses                                               |
// | ray_trace      | poses, map, beams                        | expected_m[N][M] (unfused reference)                |
// | beam_votes    | poses, log_weight, map, beams, state     | share of each beam (models that ask the cloud)      |
// | weight         | poses, map, beams (or expected_m), shares| log_weight += tempering * sum of beams              |
// | normalise_scan | log_weight                               | log_weight - max, weight[N], cumulative[N], state   |
// | estimate       | poses, weight, state                     | state's moments of all and of the heaviest cluster  |
// | adapt          | poses, cumulative, state                 | N of the other pose buffer                          |
// | resample       | poses, weight, cumulative, state         | ancestor[N], the other pose buffer, log_weight      |
// clang-format on
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/bins.h"
#include "common/filter/filter_config.h"
#include "common/map/rays/ray_cast.h"
#include "common/math/block_sum.h"
#include "common/model/beam_skip.h"
#include "common/model/likelihood_field.h"
#include "common/model/motion.h"
#include "common/model/ray_models.h"
#include "common/model/scan_shape.h"

namespace parloc {

constexpr std::int64_t kMaxParticles = std::int64_t{1} << 24;

/// Who draws random numbers in this step.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t step = 0;
};

/// Everything that changes from step to step, in one piece of memory: one copy brings it to the backend's
/// space, and the stages of a recorded step find it where it always is. The arrays of the beams lie behind
/// it.
struct alignas(16) StepInput {
  MotionStep motion;
  RandomKey key;
  ScanShape scan;
  RayModels models;  ///< They depend on the maximum range.
  float tempering = 1.0f;
  std::uint32_t all_particles = 0;  ///< adapt: as many as there can be.
  float scan_worth = 0.0f;          ///< Independent beams that the scan counts for; 0: no scan.
};

/// Structure of arrays, `capacity` entries each, of which the first count() are particles.
struct Particles {
  float* x = nullptr;
  float* y = nullptr;
  float* theta = nullptr;
  float* log_weight = nullptr;
  std::uint32_t* live = nullptr;  ///< [1] The number of particles, 1 to capacity.
  std::size_t capacity = 0;
  /// In the backend's space: on the host this is for the CPU's loops, which ask once.
  PARLOC_HD std::size_t count() const { return *live; }
};

/// A BeamTable in the backend's memory (common/model/beams.h).
struct Beams : ScanShape {
  const float* origin_x = nullptr;
  const float* origin_y = nullptr;
  const float* direction_x = nullptr;
  const float* direction_y = nullptr;
  const float* range_m = nullptr;
  const float* short_density = nullptr;
  const float* end_x = nullptr;
  const float* end_y = nullptr;
};

struct PredictArgs {
  Particles particles;
  const StepInput* input = nullptr;
};

struct RayTraceArgs {
  Particles particles;
  RayMap map;
  Beams beams;  ///< The arrays; their shape is that of the input.
  const StepInput* input = nullptr;
  RayCaster caster = RayCaster::skip;
  float fixed_step_cells = 0.5f;
  float* expected_m = nullptr;  ///< [N][M], row per particle; range_max_m where nothing is hit.
};

struct StepState;

/// What the particles together make of each beam (common/filter/beam_votes.h); null for models that do not
/// ask.
struct BeamVotes {
  std::uint64_t* map = nullptr;       ///< [kMaxBeams] That it saw the map. Zero between the steps.
  std::uint64_t* unmapped = nullptr;  ///< [kMaxBeams] That it saw something else; likewise.
  float* share = nullptr;             ///< [kMaxBeams] How far it counts, 0 to 1.
};

/// `rays.expected_m` null: rays are traced on the fly (fused), nothing of size N x M is stored. Else it holds
/// what ray_trace wrote. Same bits either way.
struct WeightArgs {
  RayTraceArgs rays;
  SensorModel model = SensorModel::likelihood_field;
  LikelihoodField field;  ///< Of models that cast no rays.
  BeamSkip skip;
  BeamVotes votes;
  const StepState* state = nullptr;  ///< Of the step before.
  float tempering = 1.0f;            ///< From the input, and so the next.
  RayModels models{};                ///< Of the models that cast rays.
};

/// Weighted sums that an estimate is made of; in the grid frame.
struct Moments {
  double weight = 0;               ///< Share of the total.
  double x = 0, y = 0, theta = 0;  ///< Mean; theta circular.
  double resultant = 0;            ///< R of the circular mean.
  double xx = 0, xy = 0, xt = 0, yy = 0, yt = 0,
         tt = 0;  ///< Covariance about the mean, heading differences wrapped.
};

/// Running means of a scan's likelihood (common/filter/weights/recovery.h), as logarithms per beam.
struct LikelihoodMeans {
  double scan = 0;            ///< Of the last scan alone.
  double slow = 0, fast = 0;  ///< Over the scans so far.
  std::uint32_t scans = 0;    ///< 0: there has been none; else 1.
};

/// The one small struct that comes up per step.
struct StepState {
  float max_log_weight = 0;
  std::uint32_t degenerate = 0;  ///< All weights were zero.
  std::uint32_t resample = 0;    ///< N_eff < threshold * N.
  std::uint32_t best_slot = 0;   ///< Bin-table slot of the heaviest cluster's root.
  std::uint32_t count = 0;       ///< N of the weighed particles.
  std::uint32_t next_count = 0;  ///< N of those that resampling makes of them.
  std::uint64_t total = 0;       ///< Sum of the fixed-point weights.
  double n_eff = 0;
  LikelihoodMeans likelihood;
  double inject = 0;  ///< Share of the offspring that is drawn from free space instead.
  Moments all;
  Moments cluster;
};

/// Fixed-point weights of a particle set.
struct Weights {
  std::uint64_t* weight = nullptr;      ///< [N] round(exp(log_weight - max) 2^S)
  std::uint64_t* cumulative = nullptr;  ///< [N] inclusive sum; where `before` is given, of its block alone
  std::uint64_t* before = nullptr;      ///< [N / kSumBlock, rounded up] Sum of all blocks before; or null.

  PARLOC_HD std::uint64_t sum_to(std::size_t i) const {
    return before == nullptr ? cumulative[i] : before[i / kSumBlock] + cumulative[i];
  }
};

/// Rates of the running means as logarithms: of what a scan adds, and of what is kept.
struct RecoveryRates {
  bool on = false;
  double add_slow = 0, keep_slow = 0;
  double add_fast = 0, keep_fast = 0;
  double margin = 0;  ///< Logarithm of the factor by which the fast mean may be below the slow one.
};

struct NormaliseArgs {
  Particles particles;
  Weights weights;
  double threshold = 0.5;  ///< tau: resample iff total^2 < tau N sum(q^2), i.e. N_eff < tau N.
  bool always = false;     ///< Resample in any case.
  StepState* state = nullptr;
  RecoveryRates recovery;
  const StepInput* input = nullptr;
  bool just_weighed = false;  ///< The stage before this one was weight, of the same particles.
};

struct EstimateArgs {
  Particles particles;
  Weights weights;
  BinTable bins;  ///< Empty before and after.
  StepState* state = nullptr;
};

/// The free cells of the map, for poses drawn anywhere; none if nothing is ever drawn.
struct FreeSpace {
  const std::uint32_t* cell = nullptr;  ///< [count] row-major
  std::uint32_t count = 0;
  std::uint32_t width = 0;
  float resolution_m = 0;
};

struct ResampleArgs {
  Particles from;
  Particles to;  ///< The other poses, as many as `to` says; always written: copies when state.resample is 0.
                 ///< May share log_weight.
  Weights weights;
  ResampleScheme scheme = ResampleScheme::systematic;
  const StepInput* input = nullptr;
  const StepState* state = nullptr;
  std::uint32_t* ancestor = nullptr;       ///< [N]
  std::uint64_t* offspring_sum = nullptr;  ///< [N] scratch of the residual scheme (null otherwise)
  std::uint64_t* remainder_sum = nullptr;  ///< [N] likewise
  FreeSpace free;
  RandomKey key{};  ///< From the input.
};

/// What a stage works with: `args` with what the input says of this step.
PARLOC_HD RayTraceArgs with_input(RayTraceArgs args) {
  static_cast<ScanShape&>(args.beams) = args.input->scan;
  return args;
}
PARLOC_HD WeightArgs with_input(WeightArgs args) {
  args.rays = with_input(args.rays);
  args.models = args.rays.input->models;
  args.tempering = args.rays.input->tempering;
  return args;
}
PARLOC_HD ResampleArgs with_input(ResampleArgs args) {
  args.key = args.input->key;
  return args;
}

}  // namespace parloc
