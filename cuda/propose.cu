#include "cuda/match_sum.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// A block per particle. Its first thread decides which poses are looked at next; warps take one each.
struct Propose {
  struct Shared {
    unsigned char proposer[sizeof(Proposer)];
    PoseSums sums;
    Proposer::Room room;
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
    if (phase % 2 == 1) return s.sums.answer(me, maps.of(i), beams, rules.match);
    if (me.thread > 0 || (phase > 0 && s.sums.wanted == 0)) return;
    Proposer& proposer = *reinterpret_cast<Proposer*>(s.proposer);
    if (phase == 0) {
      proposer = Proposer{};
      proposer.begin(slam_pose(p, i), static_cast<std::uint32_t>(i), rules);
    } else {
      proposer.take(s.sums.sums(), s.room, rules);
    }
    s.sums.ask(proposer, rules, rules.match);
    if (s.sums.wanted == 0) put(proposer, i);
  }

 private:
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
