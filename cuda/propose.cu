#include "cuda/match_sum.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// A block per particle. Its first thread decides which poses are looked at next; warps take one each. What a
/// scan says in the box around the best fit is worked out by as many threads as it has points, and its
/// moments by one for each.
struct Propose {
  struct Shared {
    unsigned char proposer[sizeof(Proposer)];
    PoseSums sums;
    Proposer::Room room;
    float beams[5][kMostSlamBeams];  // end x and y, direction x and y, range: read again for every pose
    double most;                     // of the logs
    double weight[kBoxPoints];
    double sum[4];     // of offsets along x, y, heading; of weights
    double spread[9];  // row-major
  };
  enum LastPhases { kAnswer, kBoxLogs, kBoxWeights, kBoxSums, kBoxSpread, kPut, kLastPhases };
  SlamArgs given;

  PARLOC_HD int matching_phases() const { return 1 + 2 * Proposer::most_matching_rounds(given.rules); }
  PARLOC_HD int phases() const { return matching_phases() + kLastPhases; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const std::size_t i = me.block;
    if (i >= given.particles.count()) return;
    Proposer& proposer = *reinterpret_cast<Proposer*>(s.proposer);
    const int round = phase / 2, last = phase - matching_phases();
    if (last >= 0) return finish(me, last, proposer, s);
    if (phase % 2 == 1) return answer(me, round, s.sums.wanted, proposer, s);
    s.sums.clear(me.thread, round);
    if (phase == 0) bring_beams(me.thread, s);
    if (me.thread > 0 || (phase > 0 && s.sums.wanted == 0)) return;
    const SlamArgs a = with_input(given);
    if (phase == 0) {
      keep_one(a, i);
      proposer = Proposer{};
      proposer.begin(slam_pose(a.particles, i), static_cast<std::uint32_t>(i), a.rules);
    } else {
      proposer.take(s.sums.sums(round - 1), s.room.bound, a.rules);
    }
    s.sums.wanted = proposer.is_matching() ? proposer.wanted() : 0;
  }

 private:
  PARLOC_HD void bring_beams(unsigned t, Shared& s) const {
    const Beams& b = given.beams;
    for (std::size_t m = t; m < given.input->scan.hits; m += kThreads) {
      s.beams[0][m] = b.end_x[m], s.beams[1][m] = b.end_y[m];
      s.beams[2][m] = b.direction_x[m], s.beams[3][m] = b.direction_y[m];
      s.beams[4][m] = b.range_m[m];
    }
  }
  PARLOC_HD void answer(const Thread& me, int round, int poses, const Proposer& proposer, Shared& s) const {
    if (poses == 0) return;
    Beams beams;
    beams.hits = given.input->scan.hits;
    beams.end_x = s.beams[0], beams.end_y = s.beams[1];
    beams.direction_x = s.beams[2], beams.direction_y = s.beams[3];
    beams.range_m = s.beams[4];
    s.sums.answer(me, round, poses, proposer, given.rules, given.maps.of(me.block), beams, given.rules.match);
  }
  PARLOC_HD void finish(const Thread& me, int phase, Proposer& proposer, Shared& s) const {
    const int t = static_cast<int>(me.thread), round = Proposer::most_matching_rounds(given.rules);
    if (phase == kAnswer) return answer(me, round, proposer.wanted(), proposer, s);
    if (phase == kPut) {
      if (t == 0) put(me.block, round, with_input(given), proposer, s);
    } else if (proposer.is_in_box()) {
      weigh_box(t, phase, s.sums.sums(round), given.rules, proposer, s);
    }
  }
  PARLOC_HD static void weigh_box(int t, int phase, const std::int32_t* sums, const ProposeRules& rules,
                                  const Proposer& proposer, Shared& s) {
    const auto offset = [&](int k) { return rules.box.offset(k); };
    if (phase == kBoxLogs && t < kBoxPoints) s.room.log[t] = proposer.box_log(t, sums[t], rules);
    if (phase == kBoxWeights && t < kBoxPoints) {
      const double most = largest_of(s.room.log, kBoxPoints);
      s.weight[t] = portable_exp64(s.room.log[t] - most);
      if (t == 0) s.most = most;
    }
    if (phase == kBoxSums && t < 4) {
      double sum = 0.0;
      add_offsets(s.weight, kBoxPoints, offset, t, t + 1, &sum);
      s.sum[t] = sum;
    }
    if (phase == kBoxSpread && t < 9) {
      double spread = 0.0;
      add_spread(s.weight, kBoxPoints, s.sum[3], shift_of(s.sum), offset, t, t + 1, &spread);
      s.spread[t] = spread;
    }
  }
  PARLOC_HD static void put(std::size_t i, int round, const SlamArgs& a, Proposer& proposer,
                            const Shared& s) {
    if (proposer.is_in_box()) {
      ProposalMoments m;
      m.shift = shift_of(s.sum);
      for (int e = 0; e < 9; ++e) m.covariance.m[e] = s.spread[e];
      m.log_eta = s.most + portable_log64(s.sum[3]);
      proposer.finish_box(m, a.rules);
    } else if (!proposer.done()) {
      proposer.take(s.sums.sums(round), static_cast<std::int32_t*>(nullptr), a.rules);
    }
    const Particles& p = a.particles;
    p.x[i] = proposer.pose().x, p.y[i] = proposer.pose().y, p.theta[i] = proposer.pose().theta;
    p.log_weight[i] += proposer.log_weight();
    a.likelihood[i] += proposer.log_weight();
  }
};

}  // namespace

void SlamStages::propose(const SlamArgs& args, Queue& queue) {
  launch(Propose{args}, static_cast<unsigned>(args.particles.capacity), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
