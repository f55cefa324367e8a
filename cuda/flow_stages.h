// The stages of flow and Kalman filters as kernels; contract in common/flow/flow_stages.h. All are
// asynchronous on the queue and can be recorded.
#pragma once

#include "common/filter/engine/step_input_buffer.h"
#include "common/flow/flow_stages.h"
#include "common/flow/mean_update.h"
#include "cuda/queue.h"

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

/// The scan, which beams of it count, and updates in the middle of their work, in device memory.
class FlowRoom {
 public:
  explicit FlowRoom(const FlowConfig& config) {
    mean.reserve(1), beams.reserve(1);
    if (!(config.z_score > 0.0)) return;
    distance.reserve(kMaxBeams), keep.reserve(kMaxBeams), kept.reserve(1);
  }
  /// Returns whether its arrays moved.
  template <class Space>
  void set_scan(const BeamTable& t, StepInputBuffer<Space>& input) {
    input.set_scan(t);
    arrays_ = input.beams();
  }
  FlowScan scan(const FlowArgs& args) const { return {arrays_, args.input, keep.data(), kept.data()}; }

  DeviceBuffer<UpdateWork<MeanUpdate>> mean;
  DeviceBuffer<UpdateWork<BeamsUpdate>> beams;
  DeviceBuffer<float> distance, keep, kept;  // with a z score only

 private:
  Beams arrays_;
};

struct FlowStages {
#include "common/flow/stage_list.inc"
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
