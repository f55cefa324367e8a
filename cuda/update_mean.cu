#include "common/flow/mean_update.h"

#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct PredictMean {
  FlowRules rules;
  const StepInput* input;
  FlowState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) predict_state(*state, rules, motion_noise(input->motion));
  }
};

struct FinishState {
  FlowRules rules;
  FlowState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) finish_state(*state, rules);
  }
};

/// One warp of one block adds up the beams, its first thread does the algebra in between: nothing goes to the
/// host until the last linearisation is done.
template <class Update, class Terms>
struct UpdateMean {
  struct Shared {
    LaneSums<Terms::kSums> sums;
  };
  DistanceField field;
  FlowRules rules;
  FlowScan scan;
  Terms terms;
  FlowState* state;
  CloudMove* move;
  UpdateWork<Update>* work;
  int most_sums;

  PARLOC_HD int phases() const { return 2 + kSumPhases * most_sums; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const std::size_t lane = me.thread;
    if (lane >= kBeamLanes) return;
    if (phase == 0) {
      if (lane > 0) return;
      work->update.begin(*state, rules);
      return ask();
    }
    if (phase + 1 == phases()) {
      if (lane == 0) work->update.end(*state, *move);
      return;
    }
    if (!work->active) return;
    const int part = (phase - 1) % kSumPhases;
    if (part == 0) return sum_lane(field, scan, work->pose, terms, lane, s.sums);
    if (part + 1 < kSumPhases) {
      const std::size_t offset = kBeamLanes >> part;
      if (lane < offset) s.sums.fold(lane, offset);
      return;
    }
    if (lane > 0) return;
    work->update.take(s.sums.total(), static_cast<double>(scan.count()), field, rules, *state);
    ask();
  }

 private:
  PARLOC_HD void ask() const {
    work->active = scan.count() > 0.0f && !work->update.done();
    work->pose = scan_pose(work->update.at(), field);
  }
};

}  // namespace

void predict_mean(const FlowRules& rules, const StepInput* input, FlowState* state, Stream stream) {
  launch(PredictMean{rules, input, state}, 1, stream);
}

void finish_mean_state(const FlowRules& rules, FlowState* state, Stream stream) {
  launch(FinishState{rules, state}, 1, stream);
}

void update_mean(const DistanceField& field, const FlowRules& rules, const FlowScan& scan, FlowState* state,
                 CloudMove* move, const UpdateRoom& room, Stream stream) {
  if (rules.method == FlowMethod::ekf_beams)
    return launch(UpdateMean<BeamsUpdate, InformationTerms>{field, rules, scan, rules.information, state,
                                                            move, room.beams.data(), rules.iterations},
                  1, stream);
  launch(UpdateMean<MeanUpdate, MeanTerms>{field, rules, scan, MeanTerms{}, state, move, room.mean.data(),
                                           MeanUpdate::most_sums(rules)},
         1, stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
