// Sums over the beams of a scan at a pose, in three straight loops: where the end points fall, the four cells
// around each of them, what they mean. The one in the middle is one plain load of 16 bytes per beam.
#pragma once

#include <algorithm>
#include <cstring>

#include "common/flow/field_measurement.h"
#include "common/model/beams.h"

namespace parloc::cpu {

/// The hits of a scan, filled up to full vectors with beams that do not count.
struct PaddedScan {
  alignas(64) float end_x[kMaxBeams];
  alignas(64) float end_y[kMaxBeams];
  alignas(64) float direction_x[kMaxBeams];
  alignas(64) float direction_y[kMaxBeams];
  alignas(64) float keep[kMaxBeams];  ///< 1: it counts; else 0.
  std::size_t hits = 0;
  std::size_t full = 0;  ///< `hits`, rounded up.
  float kept = 0.0f;

  void set(const BeamTable& t) {
    hits = t.hits;
    full = (hits + kBeamLanes - 1) / kBeamLanes * kBeamLanes;
    kept = static_cast<float>(hits);
    const auto fill = [this](const std::vector<float>& from, float* to) {
      std::copy_n(from.begin(), hits, to);
      std::fill(to + hits, to + full, 0.0f);
    };
    fill(t.end_x, end_x);
    fill(t.end_y, end_y);
    fill(t.direction_x, direction_x);
    fill(t.direction_y, direction_y);
    std::fill_n(keep, hits, 1.0f);
    std::fill(keep + hits, keep + full, 0.0f);
  }
};
static_assert(kMaxBeams % kBeamLanes == 0);

/// One thread's notes on one pose.
struct BeamNotes {
  struct Corners {
    DistancePair left, right;
  };
  alignas(64) float arm_x[kMaxBeams];
  alignas(64) float arm_y[kMaxBeams];
  alignas(64) float right[kMaxBeams];
  alignas(64) float up[kMaxBeams];
  alignas(64) std::int32_t at[kMaxBeams];
  alignas(64) Corners corners[kMaxBeams];
};

/// Fills in where all end points fall, and the cells around them.
PARLOC_HD void find_corners(const DistanceField& field, const PaddedScan& scan, const ScanPose& pose,
                            BeamNotes& notes) {
  const DistanceTable table = field.table;
  for (std::size_t m = 0; m < scan.full; ++m) {
    const BeamArm arm = beam_arm(pose, scan.end_x[m], scan.end_y[m]);
    const TablePlace place = table.place(pose.u + arm.x, pose.v + arm.y);
    notes.arm_x[m] = arm.x, notes.arm_y[m] = arm.y;
    notes.right[m] = place.right, notes.up[m] = place.up;
    notes.at[m] = place.at;
  }
  for (std::size_t m = 0; m < scan.full; ++m)
    std::memcpy(&notes.corners[m], table.entries + notes.at[m], sizeof notes.corners[m]);
}

/// Of one beam, once its corners are there.
PARLOC_HD FieldValue value_of(const DistanceField& field, const BeamNotes& notes, std::size_t m) {
  const BeamNotes::Corners& c = notes.corners[m];
  return capped(bilinear_patch(c.left, c.right, notes.right[m], notes.up[m]), field.cap_cells);
}

/// Sums of `terms` over the beams that count.
template <class Terms>
PARLOC_HD BeamTerms<Terms::kSums> sum_beams(const DistanceField& field, const PaddedScan& scan,
                                            const ScanPose& pose, const Terms& terms, BeamNotes& notes) {
  const bool cubic = field.interpolation == FieldInterpolation::cubic;
  constexpr int kSums = Terms::kSums;
  LaneSums<kSums> sums;
  for (std::size_t l = 0; l < kBeamLanes; ++l) sums.clear(l);
  if (!cubic) find_corners(field, scan, pose, notes);
  for (std::size_t first = 0; first < scan.full; first += kBeamLanes) {
    if (cubic) {
      for (std::size_t m = first; m < first + kBeamLanes; ++m) {
        if (scan.keep[m] == 0.0f) continue;
        const BeamArm arm = beam_arm(pose, scan.end_x[m], scan.end_y[m]);
        const FieldValue f = look_up(field, pose, arm);
        sums.add(m - first, terms(f, beam_slopes(f, pose, arm, scan.direction_x[m], scan.direction_y[m])));
      }
      continue;
    }
    for (std::size_t l = 0; l < kBeamLanes; ++l) {
      const std::size_t m = first + l;
      const FieldValue f = value_of(field, notes, m);
      const BeamSlopes slopes =
          beam_slopes(f, pose, {notes.arm_x[m], notes.arm_y[m]}, scan.direction_x[m], scan.direction_y[m]);
      const BeamTerms<kSums> t = terms(f, slopes);
      for (int k = 0; k < kSums; ++k) sums.lane[k][l] += scan.keep[m] * t.v[k];
    }
  }
  return sums.fold_all();
}

}  // namespace parloc::cpu
