// The likelihood field of a whole scan, in three straight loops: where the end points fall, what the table
// holds there, what it means. The one in the middle is the price: an end point takes one load of 8 bytes,
// plain, for gathers are no quicker, and the loads of all end points are on their way at the same time.
#pragma once

#include <cstring>

#include "common/filter/beam_votes.h"
#include "common/model/beams.h"

namespace parloc::cpu {

/// End points of the hits that count [cells, base frame]; then some of no meaning, up to a full vector.
struct EndPoints {
  static constexpr std::size_t kFull = 16;
  alignas(64) float x[kMaxBeams];
  alignas(64) float y[kMaxBeams];
  std::size_t count = 0;

  explicit EndPoints(const WeightArgs& a) {
    const Beams& b = a.rays.beams;
    const bool judged = needs_beam_votes(a);
    for (std::size_t m = 0; m < b.hits; ++m) {
      if (judged && a.votes.share[m] == 0.0f) continue;
      x[count] = b.end_x[m];
      y[count++] = b.end_y[m];
    }
    for (std::size_t m = count; m < full(); ++m) x[m] = y[m] = 0.0f;
  }
  std::size_t full() const { return (count + kFull - 1) / kFull * kFull; }
};
static_assert(kMaxBeams % EndPoints::kFull == 0);
static_assert(std::int64_t{kMaxBeams} * -kLeastInTable << kValueBits < std::int64_t{1} << 31,
              "a particle's sum must fit 32 bits");

/// One thread's notes on one particle.
struct FieldNotes {
  struct Pair {
    std::uint32_t left, right;
  };
  alignas(64) std::int32_t at[kMaxBeams];
  alignas(64) std::uint32_t parts[kMaxBeams];
  alignas(64) Pair pair[kMaxBeams];

  /// Points of no meaning are worth nothing.
  explicit FieldNotes(const EndPoints& ends) {
    for (std::size_t m = ends.count; m < ends.full(); ++m) pair[m] = {0, 0};
  }
};

/// Sum of the field's values at the end points of a particle.
PARLOC_HD std::int32_t field_sum(const LikelihoodField& field, const FieldPose& pose, const EndPoints& ends,
                                 FieldNotes& notes) {
  const std::size_t full = ends.full();
  for (std::size_t m = 0; m < full; ++m) {
    const FieldPlace place = field.place(pose, ends.x[m], ends.y[m]);
    notes.at[m] = place.at;
    notes.parts[m] = place.parts;
  }
  for (std::size_t m = 0; m < ends.count; ++m)
    std::memcpy(&notes.pair[m], field.entries + notes.at[m], sizeof notes.pair[m]);
  std::int32_t sum = 0;
  for (std::size_t m = 0; m < full; ++m)
    sum += LikelihoodField::value(notes.pair[m].left, notes.pair[m].right, notes.parts[m]);
  return sum;
}

}  // namespace parloc::cpu
