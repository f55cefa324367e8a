// From a particle's pose to its next one, with the scan (SPEC 9.3). Like HillClimb it asks for what the scan
// says at several poses at once.
#pragma once

#include "common/slam/gaussian_proposal.h"
#include "common/slam/matching/match_scan.h"
#include "common/slam/slam_config.h"

namespace parloc {

/// Its beams are 0 without a scan, or with nothing to match it to.
struct ProposeRules : ScanSearchRules {
  SlamProposal proposal = SlamProposal::scan_match;
  MatchRules match;
  ProposalBox box;
  float beta_weight = 0, beta_proposal = 1;
  float min_score = 0;  ///< Per beam [1/65536].
  float floor_xy = 0, floor_theta = 0;
  RandomKey key;
  MotionStep motion;
};

class Proposer {
 public:
  static constexpr int kMostPoses = ScanSearch::kMostPoses;
  static_assert(kBoxPoints <= kMostPoses);
  /// Rounds of matching; one more follows.
  PARLOC_HD static int most_matching_rounds(const ProposeRules& r) {
    return r.proposal == SlamProposal::motion ? 0 : ScanSearch::most_rounds(r.search);
  }
  /// Memory from round to round.
  struct Room {
    double log[kMostPoses];
    std::int32_t bound[WideSearch::kMostBlocks];
  };

  PARLOC_HD void begin(const SlamPose& pose, std::uint32_t slot, const ProposeRules& r) {
    least_score_ = r.min_score * static_cast<float>(r.beams);
    log_weight_ = 0.0f;
    if (r.proposal == SlamProposal::gaussian) {
      MotionNoise u = motion_noise(r.motion);
      u.spread_xy = u.spread_theta = 0.0;  // added below
      predicted_ = moved(vector_of(pose), u);
      motion_ = motion_covariance(vector_of(pose), u);
      for (int i = 0; i < 3; ++i) {
        const double floor = i < 2 ? r.motion.spread_xy : r.motion.spread_theta;
        motion_(i, i) += floor * floor;
      }
      pose_ = pose_of(predicted_);
    } else {
      pose_ = drawn(pose, slot, r);
    }
    before_ = pose;
    slot_ = slot;
    stage_ = r.beams == 0 ? Stage::end : Stage::likelihood;
    if (stage_ == Stage::end && r.proposal == SlamProposal::gaussian) pose_ = drawn(pose, slot, r);
    if (stage_ == Stage::likelihood && r.proposal != SlamProposal::motion) {
      stage_ = Stage::match;
      match_.begin(pose_, r);
    }
  }
  PARLOC_HD bool done() const { return stage_ == Stage::end; }
  PARLOC_HD Ask ask() const { return stage_ == Stage::match ? match_.ask() : Ask::likelihood; }
  PARLOC_HD int wanted() const {
    return stage_ == Stage::match ? match_.wanted()
           : stage_ == Stage::box ? kBoxPoints
           : stage_ == Stage::end ? 0
                                  : 1;
  }
  PARLOC_HD SlamPose candidate(int k, const ProposeRules& r) const {
    if (stage_ == Stage::match) return match_.candidate(k, r);
    if (stage_ == Stage::box) return pose_of(box_plus(vector_of(pose_), r.box.offset(k)));
    return pose_;
  }
  PARLOC_HD void take(const std::int32_t* sum, Room& room, const ProposeRules& r) {
    if (stage_ == Stage::box) {
      for (int k = 0; k < kBoxPoints; ++k) room.log[k] = box_log(k, sum[k], r);
      const auto offset = [&](int k) { return r.box.offset(k); };
      finish_box(proposal_moments(room.log, kBoxPoints, offset), r);
    } else {
      take(sum, room.bound, r);
    }
  }
  /// The same where it does not stand in the box.
  PARLOC_HD void take(const std::int32_t* sum, std::int32_t* bound, const ProposeRules& r) {
    if (stage_ == Stage::match) {
      match_.take(sum, bound, r);
      if (match_.done()) finish_match(r);
    } else {
      log_weight_ = r.beta_weight * nats(sum[0]);
      stage_ = Stage::end;
    }
  }
  /// It looks for the best fit; what comes then, if anything, is one round: a box or a single pose.
  PARLOC_HD bool is_matching() const { return stage_ == Stage::match; }
  PARLOC_HD bool is_in_box() const { return stage_ == Stage::box; }
  /// In the box: log of what point k weighs, of the sum over the beams there.
  PARLOC_HD double box_log(int k, std::int32_t sum, const ProposeRules& r) const {
    const Vector3 x = box_plus(vector_of(pose_), r.box.offset(k));
    return r.beta_proposal * static_cast<double>(nats(sum)) +
           log_density(motion_root_, box_minus(x, predicted_));
  }
  /// With the moments of all its points.
  PARLOC_HD void finish_box(const ProposalMoments& m, const ProposeRules& r) {
    const Normals n = normals(philox(slot_, r.key.step, Stream::slam_proposal, 0, r.key.seed));
    Vector3 noise;
    for (int i = 0; i < 3; ++i) noise[i] = n.n[i];
    Matrix3 spread = m.covariance;
    for (int i = 0; i < 3; ++i) spread(i, i) += 1e-12;
    const Vector3 drawn_at = plus(m.shift, 1.0, multiply(semidefinite_root(spread), noise));
    pose_ = pose_of(box_plus(vector_of(pose_), drawn_at));
    const double per_point = portable_log64(r.box.volume() / kBoxPoints);
    log_weight_ = static_cast<float>(r.beta_weight / r.beta_proposal * (m.log_eta + per_point));
    stage_ = Stage::end;
  }
  PARLOC_HD const SlamPose& pose() const { return pose_; }
  PARLOC_HD float log_weight() const { return log_weight_; }

 private:
  enum class Stage { match, box, likelihood, end };

  PARLOC_HD static float nats(std::int32_t sum) { return static_cast<float>(sum) / kScoreUnits; }
  PARLOC_HD static Vector3 vector_of(const SlamPose& p) {
    Vector3 v;
    v[0] = p.x, v[1] = p.y, v[2] = p.theta;
    return v;
  }
  PARLOC_HD static SlamPose pose_of(const Vector3& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), wrap(static_cast<float>(v[2]))};
  }
  PARLOC_HD static SlamPose drawn(const SlamPose& pose, std::uint32_t slot, const ProposeRules& r) {
    SlamPose p = pose;
    predict_one(p.x, p.y, p.theta, r.motion, slot, r.key.step, r.key.seed);
    spread_one(p.x, p.y, p.theta, r.motion, slot, r.key.step, r.key.seed);
    return p;
  }
  PARLOC_HD void finish_match(const ProposeRules& r) {
    const bool fits = static_cast<float>(match_.score()) > least_score_;
    if (fits) pose_ = match_.pose();
    if (!fits && r.proposal == SlamProposal::gaussian) pose_ = drawn(before_, slot_, r);
    stage_ = fits && r.proposal == SlamProposal::gaussian ? Stage::box : Stage::likelihood;
    if (stage_ == Stage::box) motion_root_ = cholesky(motion_);
  }

  ScanSearch match_;
  SlamPose pose_, before_;
  Vector3 predicted_;
  Matrix3 motion_;
  Cholesky3 motion_root_;
  std::uint32_t slot_ = 0;
  float least_score_ = 0, log_weight_ = 0;
  Stage stage_ = Stage::end;
};

}  // namespace parloc
