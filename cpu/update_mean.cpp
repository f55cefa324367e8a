#include "common/flow/mean_update.h"

#include "cpu/flow_stages.h"

namespace parloc::cpu {
namespace {

template <class Update, class Terms>
PARLOC_HD void run_update(const FlowArgs& args, FlowRoom& room, const Terms& terms) {
  const DistanceField& field = args.field;
  const FlowRules& rules = args.rules;
  const PaddedScan& scan = room.scan;
  FlowState& state = *args.state;
  Update update;
  update.begin(state, rules);
  while (scan.kept > 0.0f && !update.done()) {
    const ScanPose pose = scan_pose(update.at(), field);
    const auto sum = sum_beams(field, scan, pose, terms, room.notes);
    update.take(sum, static_cast<double>(scan.kept), field, rules, state);
  }
  update.end(state, *args.move);
}

}  // namespace

void FlowStages::predict_mean(const FlowArgs& args, Queue&) {
  const StrictFloat strict;
  predict_state(*args.state, args.rules, motion_noise(args.input->motion));
}

void FlowStages::update_mean(const FlowArgs& args, FlowRoom& room, Queue&) {
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    if (args.rules.method == FlowMethod::ekf_beams)
      run_update<BeamsUpdate>(args, room, args.rules.information);
    else
      run_update<MeanUpdate>(args, room, MeanTerms{});
  });
}

void FlowStages::finish_update(const FlowArgs& args, Queue&) {
  finish_state(*args.state, args.rules);
}

}  // namespace parloc::cpu
