// Scan matching by climbing: from a pose, the best of six small moves as long as one is better, then smaller
// ones (SPEC 9.2; as in GMapping). It asks for the scores of several poses at once; who adds up the beams is
// the backend's affair.
#pragma once

#include "common/slam/matching/match_beam.h"

namespace parloc {

struct ClimbRules {
  float step_xy = 0, step_theta = 0;  ///< Of the first moves [m, rad].
  int halvings = 0;                   ///< Of the steps, before it ends.
  /// What a pose must score more per beam a metre from the start, and else by the square of its distance:
  /// holds a robot in a corridor, where nothing in the scan says how far along it is [1/m^2].
  float pull = 0;
};

class HillClimb {
 public:
  static constexpr int kMoves = 6;
  static constexpr int kMostRounds = 64;  ///< Then it ends, wherever it is.

  /// `beams`: that a score is the sum of.
  PARLOC_HD void begin(const SlamPose& start, const ClimbRules& rules, std::size_t beams) {
    start_ = best_ = start;
    pull_ = rules.pull * kScoreUnits * static_cast<float>(beams);
    score_ = 0;
    step_xy_ = rules.step_xy, step_theta_ = rules.step_theta;
    halvings_ = rules.halvings;
    rounds_left_ = kMostRounds;
    started_ = false;
    back_ = kMoves;
  }
  PARLOC_HD bool done() const { return started_ && (halvings_ <= 0 || rounds_left_ <= 0); }
  /// Poses that it asks for now.
  PARLOC_HD int wanted() const { return done() ? 0 : !started_ ? 1 : back_ < kMoves ? kMoves - 1 : kMoves; }
  PARLOC_HD SlamPose candidate(int k) const { return started_ ? after(move(k)) : best_; }
  PARLOC_HD void take(const std::int32_t* score) {
    if (!started_) {
      --rounds_left_;
      started_ = true;
      score_ = score[0];
      return;
    }
    int better = -1;
    std::int32_t most = score_;
    for (int k = 0, n = wanted(); k < n; ++k) {
      const std::int32_t held = score[k] - held_back(candidate(k));
      if (held > most) better = move(k), most = held;
    }
    --rounds_left_;
    if (better >= 0) {
      best_ = after(better);
      score_ = most;
      back_ = better ^ 1;  // whence it came: a lower score, and it is known
      return;
    }
    back_ = kMoves;
    --halvings_;
    step_xy_ *= 0.5f, step_theta_ *= 0.5f;
  }
  PARLOC_HD const SlamPose& pose() const { return best_; }
  /// Less what holds it back.
  PARLOC_HD std::int32_t score() const { return score_; }

 private:
  /// The moves that are asked for, without the one back.
  PARLOC_HD int move(int k) const { return k + (k >= back_ ? 1 : 0); }
  /// Moves 0 to 5: +x, -x, -y, +y, +heading, -heading.
  PARLOC_HD SlamPose after(int move) const {
    SlamPose p = best_;
    const float xy = move == 1 || move == 2 ? -step_xy_ : step_xy_;
    p.x += move < 2 ? xy : 0.0f;
    p.y += move == 2 || move == 3 ? xy : 0.0f;
    p.theta = move < 4 ? p.theta : wrap(p.theta + (move == 4 ? step_theta_ : -step_theta_));
    return p;
  }

  PARLOC_HD std::int32_t held_back(const SlamPose& p) const {
    if (pull_ == 0.0f) return 0;  // and where p is need not be worked out
    const float dx = p.x - start_.x, dy = p.y - start_.y;
    return static_cast<std::int32_t>(min_of(pull_ * fused(dx, dx, dy * dy), kMostHeldBack));
  }

  static constexpr float kMostHeldBack = 2e9f;  // with any score within 32 bits
  SlamPose start_, best_;
  float pull_ = 0;
  std::int32_t score_ = 0;
  float step_xy_ = 0, step_theta_ = 0;
  int halvings_ = 0, rounds_left_ = 0, back_ = kMoves;
  bool started_ = false;
};

}  // namespace parloc
