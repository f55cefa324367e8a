// Scan matching by climbing: from a pose, the best of six small moves as long as one is better, then smaller
// ones (SPEC 9.2; as in GMapping). It asks for the scores of several poses at once; who adds up the beams is
// the backend's affair.
#pragma once

#include "common/slam/match_beam.h"

namespace parloc {

struct ClimbRules {
  float step_xy = 0, step_theta = 0;  ///< Of the first moves [m, rad].
  int halvings = 0;                   ///< Of the steps, before it ends.
};

class HillClimb {
 public:
  static constexpr int kMoves = 6;
  static constexpr int kMostRounds = 64;  ///< Then it ends, wherever it is.

  PARLOC_HD void begin(const SlamPose& start, const ClimbRules& rules) {
    best_ = start;
    score_ = 0;
    step_xy_ = rules.step_xy, step_theta_ = rules.step_theta;
    halvings_ = rules.halvings;
    rounds_left_ = kMostRounds;
    started_ = false;
  }
  PARLOC_HD bool done() const { return halvings_ <= 0 || rounds_left_ <= 0; }
  /// Poses that it asks for now.
  PARLOC_HD int wanted() const { return done() ? 0 : (started_ ? kMoves : 1); }
  PARLOC_HD SlamPose candidate(int k) const {
    if (!started_) return best_;
    SlamPose p = best_;
    const float xy = k == 1 || k == 2 ? -step_xy_ : step_xy_;
    p.x += k < 2 ? xy : 0.0f;
    p.y += k == 2 || k == 3 ? xy : 0.0f;
    p.theta = k < 4 ? p.theta : wrap(p.theta + (k == 4 ? step_theta_ : -step_theta_));
    return p;
  }
  PARLOC_HD void take(const std::int32_t* score) {
    --rounds_left_;
    if (!started_) {
      started_ = true;
      score_ = score[0];
      return;
    }
    int better = -1;
    std::int32_t most = score_;
    for (int k = 0; k < kMoves; ++k)
      if (score[k] > most) better = k, most = score[k];
    if (better >= 0) {
      best_ = candidate(better);
      score_ = most;
      return;
    }
    --halvings_;
    step_xy_ *= 0.5f, step_theta_ *= 0.5f;
  }
  PARLOC_HD const SlamPose& pose() const { return best_; }
  PARLOC_HD std::int32_t score() const { return score_; }

 private:
  SlamPose best_;
  std::int32_t score_ = 0;
  float step_xy_ = 0, step_theta_ = 0;
  int halvings_ = 0, rounds_left_ = 0;
  bool started_ = false;
};

}  // namespace parloc
