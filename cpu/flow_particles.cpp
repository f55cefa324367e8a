#include "common/flow/particle_flow.h"

#include "common/filter/weights/normalise.h"
#include "cpu/flow_stages.h"

namespace parloc::cpu {

void FlowStages::flow_particles(const FlowArgs& args, FlowRoom& room, Queue& workers) {
  const DistanceField& field = args.field;
  const FlowRules& rules = args.rules;
  const FlowState& state = *args.state;
  const Particles p = args.particles;
  const RandomKey key = args.input->key;
  const PaddedScan& scan = room.scan;
  const bool weighted = rules.method == FlowMethod::pfpf;
  const bool has_scan = scan.kept > 0.0f && state.skip == FlowSkip::none;
  if (!weighted && !has_scan) return;
  const MotionNoise u = motion_noise(args.input->motion);
  const auto loop = [&](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    BeamNotes notes;
    for (std::size_t i = begin; i < end; ++i) {
      ParticleFlow flow;
      if (weighted)
        flow.begin_weighted(propose(pose_of(p, i), u, rules, static_cast<std::uint32_t>(i), key), rules);
      else
        flow.begin_local(state.centre, state.prior.covariance, pose_of(p, i), rules);
      while (has_scan && !flow.done()) {
        const ScanPose pose = scan_pose(flow.at(), field);
        const auto sum = sum_beams(field, scan, pose, MeanTerms{}, notes);
        flow.take(finish_measurement(sum, static_cast<double>(scan.kept), field), rules, state.r_scale);
      }
      put_pose(flow.pose(), p, i);
      if (weighted && has_scan) p.log_weight[i] += static_cast<float>(flow.log_weight());
    }
  };
  parallel_blocks(p.count(), workers.threads, 1, loop);
}

}  // namespace parloc::cpu
