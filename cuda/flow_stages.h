// The stages of flow and Kalman filters as kernels; contract in common/flow/flow_backend.h. All are
// asynchronous on `stream` and can be recorded: what changes from step to step they read from `input` and
// `state`, in device memory.
#pragma once

#include "common/flow/cloud_moments.h"
#include "common/flow/mean_update.h"
#include "cuda/launch.h"
#include "cuda/stages.h"
#include "cuda/step_input.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// The scan as kernels find it. `keep` and `kept` null: every hit counts.
struct FlowScan {
  Beams beams;  ///< The arrays; how many there are says `input`.
  const StepInput* input = nullptr;
  const float* keep = nullptr;  ///< [hits] 1: it counts; else 0.
  const float* kept = nullptr;  ///< [1] How many count.

  PARLOC_HD std::size_t hits() const { return input->scan.hits; }
  PARLOC_HD float count() const { return kept != nullptr ? *kept : static_cast<float>(hits()); }
  PARLOC_HD bool counts(std::size_t m) const { return keep == nullptr || keep[m] != 0.0f; }
};

/// What lane `lane` adds of a scan at a pose.
template <class Terms>
PARLOC_HD void sum_lane(const DistanceField& field, const FlowScan& scan, const ScanPose& pose,
                        const Terms& terms, std::size_t lane, LaneSums<Terms::kSums>& sums) {
  sums.clear(lane);
  const Beams& b = scan.beams;
  for (std::size_t m = lane; m < scan.hits(); m += kBeamLanes) {
    if (!scan.counts(m)) continue;
    const BeamArm arm = beam_arm(pose, b.end_x[m], b.end_y[m]);
    const FieldValue f = look_up(field, pose, arm);
    sums.add(lane, terms(f, beam_slopes(f, pose, arm, b.direction_x[m], b.direction_y[m])));
  }
}

/// Phases of one sum over a scan: the lanes, five folds, and what is made of it.
constexpr int kSumPhases = 7;

/// Room for the object that a kernel works with, in shared memory, which holds no objects with constructors.
template <class T>
struct alignas(alignof(T)) RawRoom {
  unsigned char bytes[sizeof(T)];
  PARLOC_HD T& get() { return *reinterpret_cast<T*>(bytes); }
};

/// An update in the middle of its work, and where it wants the scan added up next, if it does.
template <class Update>
struct UpdateWork {
  Update update;
  ScanPose pose;
  bool active;
};
/// It lies in device memory.
struct UpdateRoom {
  DeviceBuffer<UpdateWork<MeanUpdate>> mean;
  DeviceBuffer<UpdateWork<BeamsUpdate>> beams;
};

void distance_table(const std::uint32_t* squared_cells, std::int32_t width, std::int32_t height,
                    DistancePair* table, Stream stream);
/// `total`: weights as state says; null: all particles weigh the same.
void cloud_moments(const Cloud& cloud, const StepState* total, bool covariance, FlowState* state,
                   Scratch& scratch, Stream stream);
void predict_mean(const FlowRules& rules, const StepInput* input, FlowState* state, Stream stream);
/// Writes `keep` and `kept`; `distance`: [kMaxBeams] scratch.
void reject_beams(const DistanceField& field, const FlowRules& rules, const FlowScan& scan,
                  const FlowState* state, float* distance, float* keep, float* kept, Stream stream);
void update_mean(const DistanceField& field, const FlowRules& rules, const FlowScan& scan, FlowState* state,
                 CloudMove* move, const UpdateRoom& room, Stream stream);
/// What the particles became goes into the Gaussian.
void finish_mean_state(const FlowRules& rules, FlowState* state, Stream stream);
void move_cloud(const Particles& particles, const CloudMove* move, const FlowState* state,
                const StepInput* input, Stream stream);
void flow_particles(const DistanceField& field, const FlowRules& rules, const FlowScan& scan,
                    const FlowState* state, const Particles& particles, Stream stream);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
