// Which beams saw the map, as all particles together see it. Sums of integers, so that no order matters.
//
// class_conditional: each hit has an unknown class, map or unmapped, which is a fact about the scan and so
// the same for every particle. One step of expectation-maximisation over the cloud: the particles, by their
// weights before the scan, vote with the density that the beam has under either class; the share of the map
// is the posterior of that class. Only what is measured shorter than expected can be unmapped, as in the
// distance filter of Fox, Burgard & Thrun 1999: nobody sees through walls.
//
// likelihood_field_prob: the votes are counts of the particles that agree, and a share is 0 or 1.
#pragma once

#include "common/filter/stages.h"
#include "common/math/fixed_point.h"

namespace parloc {

/// Whether the model weighs a beam by what the cloud makes of it.
PARLOC_HD bool needs_beam_votes(const WeightArgs& a) {
  return a.model == SensorModel::class_conditional ||
         (a.model == SensorModel::likelihood_field_prob && a.skip.squared_cells != nullptr);
}

/// A predictive density needs no more particles than this, and rays are dear; counts are of all.
constexpr std::size_t kMostClassVoters = 512;

/// At most so many of n particles vote.
PARLOC_HD std::size_t voters_of(SensorModel model, std::size_t n) {
  return model == SensorModel::class_conditional && n > kMostClassVoters ? kMostClassVoters : n;
}
PARLOC_HD std::size_t voters(const WeightArgs& a) {
  return voters_of(a.model, a.rays.particles.count());
}
/// Slot of voter k: evenly spaced.
PARLOC_HD std::size_t voter_slot(const WeightArgs& a, std::size_t k) {
  return k * a.rays.particles.count() / voters(a);
}

constexpr float kVoteScale = 1048576.0f;  // votes per voter of full weight at the mixture's peak
constexpr float kMostVotes = 1073741824.0f;

struct ClassVotes {
  std::int32_t map, unmapped;
};

/// Votes of a particle of weight w (at most 1) on a hit.
PARLOC_HD ClassVotes class_votes(const ClassConditionalBeam& model, float w, float measured_m,
                                 float short_density, float expected_m) {
  const float scale = w * (kVoteScale / (model.mixture.hit_peak + model.mixture.rand_density));
  const float map = scale * model.map_density(measured_m, expected_m);
  const float unmapped = scale * model.unmapped_density(measured_m, short_density, expected_m);
  return {static_cast<std::int32_t>(round_even(min_of(map, kMostVotes))),
          static_cast<std::int32_t>(round_even(min_of(unmapped, kMostVotes)))};
}

/// Whether the particle of heading h whose base is at (u0, v0) [cells] agrees with hit m.
PARLOC_HD bool agrees(const WeightArgs& a, float u0, float v0, const SinCos& h, std::size_t m) {
  const Beams& b = a.rays.beams;
  return a.skip.agrees(base_to_grid_x(u0, h.cos, h.sin, b.end_x[m], b.end_y[m]),
                       base_to_grid_y(v0, h.cos, h.sin, b.end_x[m], b.end_y[m]));
}

/// Share of beam m from its votes. Nobody's votes: as if there were no second class.
PARLOC_HD float share_of_votes(const WeightArgs& a, std::size_t m) {
  if (m >= a.rays.beams.hits) return 1.0f;  // nothing unmapped makes a beam longer
  const double map = static_cast<double>(a.votes.map[m]);
  if (a.model == SensorModel::likelihood_field_prob)
    return map / static_cast<double>(voters(a)) > a.skip.threshold ? 1.0f : 0.0f;
  const double all = map + static_cast<double>(a.votes.unmapped[m]);
  return all > 0.0 ? static_cast<float>(map / all) : 1.0f;
}

/// Whether all beams count although `skipped` of them have share 0: the particles are not together yet, or
/// together in the wrong place.
PARLOC_HD bool skips_nothing(const WeightArgs& a, std::uint64_t skipped) {
  if (a.model != SensorModel::likelihood_field_prob) return false;
  const Moments& before = a.state->all;
  const bool together = before.weight > 0.0 && before.xx + before.yy < a.skip.spread_m * a.skip.spread_m;
  return !together ||
         static_cast<double>(skipped) >= static_cast<double>(a.rays.beams.hits) * a.skip.error_threshold;
}

/// Weight of a particle before the scan; at most 1 after normalise_scan.
PARLOC_HD float weight_before(const Particles& particles, std::size_t i) {
  return min_of(portable_exp(particles.log_weight[i]), 1.0f);
}

/// Nat of the integers that weight adds up.
PARLOC_HD float sum_unit_nat(const WeightArgs& a) {
  return casts_rays(a.model) ? kLogLikelihoodUnit_nat : a.field.unit_nat;
}

/// The beams as the model wants them: with what it knows of each as the constant.
PARLOC_HD Beams beams_for_model(const WeightArgs& a) {
  Beams b = a.rays.beams;
  if (a.model == SensorModel::class_conditional) b.short_density = a.votes.share;
  return b;
}

}  // namespace parloc
