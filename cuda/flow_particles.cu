#include "common/flow/particle_flow.h"

#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

constexpr unsigned kSlots = kThreads / kBeamLanes;  // particles of a block, a warp each

struct FlowParticles {
  struct Shared {
    LaneSums<MeanTerms::kSums> sums[kSlots];
    ScanPose pose[kSlots];
    bool active[kSlots];
    RawRoom<ParticleFlow> flow[kSlots];
  };
  DistanceField field;
  FlowRules rules;
  FlowScan scan;
  const FlowState* state;
  Particles p;
  std::size_t first;  // particle of block 0

  PARLOC_HD int phases() const { return 2 + kSumPhases * ParticleFlow::most_sums(rules); }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const unsigned slot = me.thread / kBeamLanes;
    const std::size_t lane = me.thread % kBeamLanes;
    const std::size_t i = first + std::size_t{me.block} * kSlots + slot;
    if (i >= p.count() || (!weighted() && !has_scan())) return;
    ParticleFlow& flow = s.flow[slot].get();
    if (phase == 0) {
      if (lane > 0) return;
      begin(i, flow);
      return ask(s, slot);
    }
    if (phase + 1 == phases()) {
      if (lane == 0) put(i, flow);
      return;
    }
    const int part = (phase - 1) % kSumPhases;
    if (part + 1 == kSumPhases && lane > 0) return;  // before it reads what the first one writes
    if (!s.active[slot]) return;
    if (part == 0) return sum_lane(field, scan, s.pose[slot], MeanTerms{}, lane, s.sums[slot]);
    if (part + 1 < kSumPhases) {
      const std::size_t offset = kBeamLanes >> part;
      if (lane < offset) s.sums[slot].fold(lane, offset);
      return;
    }
    flow.take(finish_measurement(s.sums[slot].total(), static_cast<double>(scan.count()), field), rules,
              state->r_scale);
    ask(s, slot);
  }

 private:
  PARLOC_HD bool weighted() const { return rules.method == FlowMethod::pfpf; }
  PARLOC_HD bool has_scan() const { return scan.count() > 0.0f && state->skip == FlowSkip::none; }
  PARLOC_HD void begin(std::size_t i, ParticleFlow& flow) const {
    const Vector3 pose = pose_of(p, i);
    if (weighted())
      flow.begin_weighted(propose(pose, motion_noise(scan.input->motion), rules,
                                  static_cast<std::uint32_t>(i), scan.input->key),
                          rules);
    else
      flow.begin_local(state->centre, state->prior.covariance, pose, rules);
  }
  PARLOC_HD void put(std::size_t i, const ParticleFlow& flow) const {
    put_pose(flow.pose(), p, i);
    if (weighted() && has_scan()) p.log_weight[i] += static_cast<float>(flow.log_weight());
  }
  PARLOC_HD void ask(Shared& s, unsigned slot) const {
    const ParticleFlow& flow = s.flow[slot].get();
    s.active[slot] = has_scan() && !flow.done();
    s.pose[slot] = scan_pose(flow.at(), field);
  }
};

}  // namespace

void FlowStages::flow_particles(const FlowArgs& args, FlowRoom& room, Queue& queue) {
  const Particles& p = args.particles;
  constexpr std::size_t kPerLaunch = std::size_t{kMaxBlocks} * kSlots;
  for (std::size_t first = 0; first < p.capacity; first += kPerLaunch) {
    const std::size_t here = std::min(kPerLaunch, p.capacity - first);
    launch(FlowParticles{args.field, args.rules, room.scan(args), args.state, p, first},
           static_cast<unsigned>((here + kSlots - 1) / kSlots), queue);
  }
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
