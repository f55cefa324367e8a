#include "common/model/beams.h"
#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Medians on one block. The order of floats above 0 is that of their bits, so a median is found bit by bit,
/// by counting; counts do not depend on the order of threads.
struct RejectBeams {
  struct Shared {
    std::uint32_t below, found, kept;
    float middle, deviation;
  };
  static constexpr int kBits = 31;
  static constexpr int kMedianPhases = 2 * kBits;
  static constexpr int kPhases = 1 + kMedianPhases + 1 + kMedianPhases + 3;
  DistanceField field;
  FlowRules rules;
  FlowScan scan;
  const FlowState* state;
  float* distance;
  float* keep;
  float* kept;

  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const std::size_t n = scan.hits();
    if (n == 0) {
      if (me.thread == 0) *kept = 0.0f;
      return;
    }
    if (phase == 0) return look_up_all(me, s);
    if (phase <= kMedianPhases) return search(me, phase - 1, distance_of(0.0f, false), s);
    if (phase == kMedianPhases + 1) {
      if (me.thread == 0) s.middle = float_of(s.found), s.found = 0, s.below = 0;
      return;
    }
    if (phase <= 2 * kMedianPhases + 1)
      return search(me, phase - kMedianPhases - 2, distance_of(s.middle, true), s);
    if (phase + 2 < kPhases) {
      if (me.thread == 0) s.deviation = float_of(s.found);
      return;
    }
    if (phase + 1 < kPhases) return decide(me, s);
    if (me.thread == 0) *kept = static_cast<float>(s.kept);
  }

 private:
  /// A distance, or how far it is from the median.
  struct Value {
    const float* distance;
    float middle;
    bool off;
    PARLOC_HD std::uint32_t operator()(std::size_t m) const {
      return bits_of(off ? __builtin_fabsf(distance[m] - middle) : distance[m]);
    }
  };
  PARLOC_HD Value distance_of(float middle, bool off) const { return {distance, middle, off}; }

  PARLOC_HD void look_up_all(const Thread& me, Shared& s) const {
    if (me.thread == 0) s.below = s.found = s.kept = 0;
    const ScanPose pose = scan_pose(state->prior.mean, field);
    const Beams& b = scan.beams;
    for (std::size_t m = me.thread; m < scan.hits(); m += kThreads)
      distance[m] = look_up(field, pose, beam_arm(pose, b.end_x[m], b.end_y[m])).distance;
  }
  /// Whether the median has the bit: as many as half are below the number that does.
  PARLOC_HD void search(const Thread& me, int phase, const Value& value, Shared& s) const {
    if (phase % 2 == 0) {
      const std::uint32_t candidate = with_bit(s.found, phase);
      std::uint32_t below = 0;
      for (std::size_t m = me.thread; m < scan.hits(); m += kThreads) below += value(m) < candidate ? 1 : 0;
      if (below > 0) atomic_add(&s.below, below);
    } else if (me.thread == 0) {
      if (s.below <= (scan.hits() - 1) / 2) s.found = with_bit(s.found, phase);
      s.below = 0;
    }
  }
  PARLOC_HD static std::uint32_t with_bit(std::uint32_t found, int phase) {
    return found | (1u << (kBits - 1 - phase / 2));
  }
  PARLOC_HD void decide(const Thread& me, Shared& s) const {
    std::uint32_t count = 0;
    for (std::size_t m = me.thread; m < scan.hits(); m += kThreads) {
      const bool usual = is_usual(distance[m], s.middle, s.deviation, rules.z_score);
      keep[m] = usual ? 1.0f : 0.0f;
      count += usual ? 1 : 0;
    }
    if (count > 0) atomic_add(&s.kept, count);
  }
};

}  // namespace

void FlowStages::reject_beams(const FlowArgs& args, FlowRoom& room, Queue& queue) {
  launch(RejectBeams{args.field, args.rules, room.scan(args), args.state, room.distance.data(),
                     room.keep.data(), room.kept.data()},
         1, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
