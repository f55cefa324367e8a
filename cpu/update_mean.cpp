#include "common/flow/mean_update.h"

#include "cpu/flow_stages.h"

namespace parloc::cpu {
namespace {

template <class Update, class Terms>
PARLOC_HD void run_update(const DistanceField& field, const FlowRules& rules, const PaddedScan& scan,
                          const Terms& terms, FlowState& state, CloudMove& move, BeamNotes& notes) {
  Update update;
  update.begin(state, rules);
  while (scan.kept > 0.0f && !update.done()) {
    const ScanPose pose = scan_pose(update.at(), field);
    const auto sum = sum_beams(field, scan, pose, terms, notes);
    update.take(sum, static_cast<double>(scan.kept), field, rules, state);
  }
  update.end(state, move);
}

}  // namespace

void predict_mean(const FlowRules& rules, const MotionStep& motion, FlowState& state) {
  const StrictFloat strict;
  predict_state(state, rules, motion_noise(motion));
}

void update_mean(const DistanceField& field, const FlowRules& rules, const PaddedScan& scan, FlowState& state,
                 CloudMove& move, BeamNotes& notes) {
  const StrictFloat strict;
  run_simd([&]() PARLOC_SIMD_LOOP {
    if (rules.method == FlowMethod::ekf_beams)
      run_update<BeamsUpdate>(field, rules, scan, rules.information, state, move, notes);
    else
      run_update<MeanUpdate>(field, rules, scan, MeanTerms{}, state, move, notes);
  });
}

}  // namespace parloc::cpu
