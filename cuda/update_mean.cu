#include "common/flow/mean_update.h"

#include <type_traits>

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
    const int part = (phase - 1) % kSumPhases;
    if (part + 1 == kSumPhases && lane > 0) return;  // before it reads what the first one writes
    if (!work->active) return;
    if (part == 0) return sum_lane(field, scan, work->pose, terms, lane, s.sums);
    if (part + 1 < kSumPhases) {
      const std::size_t offset = kBeamLanes >> part;
      if (lane < offset) s.sums.fold(lane, offset);
      return;
    }
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

void FlowStages::predict_mean(const FlowArgs& args, Queue& queue) {
  launch(PredictMean{args.rules, args.input, args.state}, 1, queue);
}

void FlowStages::finish_update(const FlowArgs& args, Queue& queue) {
  launch(FinishState{args.rules, args.state}, 1, queue);
}

void FlowStages::update_mean(const FlowArgs& args, FlowRoom& room, Queue& queue) {
  const auto start = [&](auto update, const auto& terms, auto* work, int most_sums) {
    launch(
        UpdateMean<decltype(update), std::decay_t<decltype(terms)>>{
            args.field, args.rules, room.scan(args), terms, args.state, args.move, work, most_sums},
        1, queue);
  };
  const FlowRules& rules = args.rules;
  if (rules.method == FlowMethod::ekf_beams)
    start(BeamsUpdate{}, rules.information, room.beams.data(), rules.iterations);
  else
    start(MeanUpdate{}, MeanTerms{}, room.mean.data(), MeanUpdate::most_sums(rules));
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
