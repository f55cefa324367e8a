#include "common/math/atomics.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

constexpr unsigned kLanes = 32;  // a warp adds up the beams of one pose

/// A block per particle. Its first thread decides which poses are looked at next; warps take one each.
struct Propose {
  struct Shared {
    unsigned char proposer[sizeof(Proposer)];
    MatchPose pose[Proposer::kMostPoses];
    std::uint32_t sum[Proposer::kMostPoses];  ///< Two's complement, so that sums of either sign wrap alike.
    Proposer::Room room;
    int wanted;
    Ask ask;
  };
  ProposeRules rules;
  Beams beams;
  SlamMaps maps;
  Particles p;
  float* likelihood;

  PARLOC_HD int phases() const { return 2 + 2 * Proposer::most_rounds(rules); }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const std::size_t i = me.block;
    if (i >= p.count()) return;
    if (phase % 2 == 1) return answer(me, maps.of(i), s);
    if (me.thread > 0 || (phase > 0 && s.wanted == 0)) return;
    Proposer& proposer = *reinterpret_cast<Proposer*>(s.proposer);
    if (phase == 0) {
      proposer = Proposer{};
      proposer.begin(slam_pose(p, i), static_cast<std::uint32_t>(i), rules);
    } else {
      proposer.take(reinterpret_cast<const std::int32_t*>(s.sum), s.room, rules);
    }
    put_question(proposer, s);
    if (s.wanted == 0) put(proposer, i);
  }

 private:
  PARLOC_HD void put_question(const Proposer& proposer, Shared& s) const {
    s.wanted = proposer.wanted();
    s.ask = proposer.ask();
    for (int k = 0; k < s.wanted; ++k) {
      s.pose[k] = match_pose(proposer.candidate(k, rules), rules.match);
      s.sum[k] = 0;
    }
  }
  PARLOC_HD void answer(const Thread& me, const TileMap& map, Shared& s) const {
    for (unsigned k = me.thread / kLanes; k < static_cast<unsigned>(s.wanted); k += kThreads / kLanes) {
      const std::int32_t sum =
          sum_beams(map, beams, s.pose[k], rules.match, s.ask, me.thread % kLanes, kLanes);
      atomic_add(&s.sum[k], static_cast<std::uint32_t>(sum));
    }
  }
  PARLOC_HD void put(const Proposer& proposer, std::size_t i) const {
    p.x[i] = proposer.pose().x, p.y[i] = proposer.pose().y, p.theta[i] = proposer.pose().theta;
    p.log_weight[i] += proposer.log_weight();
    likelihood[i] += proposer.log_weight();
  }
};

}  // namespace

void SlamStages::propose(const SlamArgs& args, Queue& queue) {
  launch(Propose{args.rules, args.beams, args.maps, args.particles, args.likelihood},
         static_cast<unsigned>(args.particles.capacity), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
