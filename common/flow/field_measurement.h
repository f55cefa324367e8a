// What a scan says at a pose: psi, the mean distance of its end points to the walls, and its slopes by pose
// and by range (SPEC 7.3; eq. 8 to 10 of the published study). Distances are in cells here and in metres
// once they are summed.
#pragma once

#include <cstddef>

#include "common/filter/stages.h"
#include "common/flow/distance_table.h"
#include "common/flow/flow_config.h"
#include "common/flow/pose_algebra.h"
#include "common/math/host_device.h"

namespace parloc {

/// The field as a scan reads it.
struct DistanceField {
  DistanceTable table;
  FieldInterpolation interpolation = FieldInterpolation::bilinear;
  float cap_cells = 0.0f;
  double resolution_m = 0.0;
};

/// A pose of the grid frame [cells from the centre of cell (0, 0)].
struct ScanPose {
  float u, v, cos, sin;
};
PARLOC_HD ScanPose scan_pose(const Vector3& pose, const DistanceField& field) {
  const SinCos64 h = portable_sincos64(pose[2]);
  return {static_cast<float>(pose[0] / field.resolution_m - 0.5),
          static_cast<float>(pose[1] / field.resolution_m - 0.5), static_cast<float>(h.cos),
          static_cast<float>(h.sin)};
}

/// From the robot to a beam's end, turned into the grid frame [cells]: the lever arm of the sensor included.
struct BeamArm {
  float x, y;
};
PARLOC_HD BeamArm beam_arm(const ScanPose& p, float end_x, float end_y) {
  return {fused(p.cos, end_x, -(p.sin * end_y)), fused(p.sin, end_x, p.cos * end_y)};
}

/// The field at a beam's end.
PARLOC_HD FieldValue look_up(const DistanceField& field, const ScanPose& p, const BeamArm& arm) {
  const float u = p.u + arm.x, v = p.v + arm.y;
  if (field.interpolation == FieldInterpolation::cubic)
    return capped(cubic_patch(field.table, u, v), field.cap_cells);
  const TablePlace at = field.table.place(u, v);
  const DistancePair* entry = field.table.entries + at.at;
  return capped(bilinear_patch(entry[0], entry[1], at.right, at.up), field.cap_cells);
}

/// How distance grows as the robot turns, and as the beam gets longer; and how long the arm is. `direction`:
/// of the beam, base frame.
struct BeamSlopes {
  float turn;  ///< [cells/rad]
  float range;
  float squared_arm;  ///< [cells^2]
};
PARLOC_HD BeamSlopes beam_slopes(const FieldValue& f, const ScanPose& p, const BeamArm& arm,
                                 float direction_x, float direction_y) {
  const float dx = fused(p.cos, direction_x, -(p.sin * direction_y));
  const float dy = fused(p.sin, direction_x, p.cos * direction_y);
  return {fused(f.slope_y, arm.x, -(f.slope_x * arm.y)), fused(f.slope_x, dx, f.slope_y * dy),
          fused(arm.x, arm.x, arm.y * arm.y)};
}

/// Sums over the beams of a scan are made in a fixed shape (SPEC 0.7, S32): lane l of 32 adds the terms l,
/// l + 32, ... in that order, then lanes are folded with offsets 16 to 1. The shape, and so the bits, do not
/// depend on who adds: a warp of a GPU, or vectors of a CPU.
constexpr std::size_t kBeamLanes = 32;

/// Terms of one beam, or their sums over a scan.
template <int K>
struct BeamTerms {
  float v[K];
};

/// The sums of each lane.
template <int K>
struct LaneSums {
  float lane[K][kBeamLanes];

  PARLOC_HD void clear(std::size_t l) {
    for (int k = 0; k < K; ++k) lane[k][l] = 0.0f;
  }
  PARLOC_HD void add(std::size_t l, const BeamTerms<K>& terms) {
    for (int k = 0; k < K; ++k) lane[k][l] += terms.v[k];
  }
  /// Of one lane below `offset`: it takes over its partner.
  PARLOC_HD void fold(std::size_t l, std::size_t offset) {
    for (int k = 0; k < K; ++k) lane[k][l] += lane[k][l + offset];
  }
  /// What is left in lane 0 after all folds.
  PARLOC_HD BeamTerms<K> total() const {
    BeamTerms<K> sum;
    for (int k = 0; k < K; ++k) sum.v[k] = lane[k][0];
    return sum;
  }
  /// All folds, on one thread.
  PARLOC_HD BeamTerms<K> fold_all() {
    for (std::size_t offset = kBeamLanes / 2; offset > 0; offset /= 2)
      for (std::size_t l = 0; l < offset; ++l) fold(l, offset);
    return total();
  }
};

/// What the mean distance is summed from.
struct MeanTerms {
  static constexpr int kSums = 7;
  PARLOC_HD BeamTerms<kSums> operator()(const FieldValue& f, const BeamSlopes& s) const {
    return {{f.distance, f.slope_x, f.slope_y, s.turn, s.range * s.range, f.within_reach * f.distance,
             s.squared_arm}};
  }
};

/// The measurement of a whole scan.
struct FieldMeasurement {
  double psi_m = 0.0;           ///< How far off the scan is: beams beyond the cap count with the cap.
  double pull_m = 0.0;          ///< psi less those beams. They have no slope, so no step can answer for them.
  Vector3 slope;                ///< H: of both by x, y [1] and heading [m/rad].
  double range_slope_sq = 0.0;  ///< Sum of squared slopes by each range.
  double arm_m = 0.0;           ///< Root mean square distance of the end points from the robot.
  double beams = 0.0;           ///< That count.
};
PARLOC_HD FieldMeasurement finish_measurement(const BeamTerms<MeanTerms::kSums>& sum, double beams,
                                              const DistanceField& field) {
  FieldMeasurement z;
  if (!(beams > 0.0)) return z;
  z.psi_m = field.resolution_m * static_cast<double>(sum.v[0]) / beams;
  z.pull_m = field.resolution_m * static_cast<double>(sum.v[5]) / beams;
  z.slope[0] = static_cast<double>(sum.v[1]) / beams;
  z.slope[1] = static_cast<double>(sum.v[2]) / beams;
  z.slope[2] = field.resolution_m * static_cast<double>(sum.v[3]) / beams;
  z.range_slope_sq = static_cast<double>(sum.v[4]) / (beams * beams);
  z.arm_m = field.resolution_m * __builtin_sqrt(static_cast<double>(sum.v[6]) / beams);
  z.beams = beams;
  return z;
}

/// Noise of psi.
struct PsiNoise {
  double range_variance = 0.0;  ///< Of a range [m^2].
  double floor_variance = 0.0;  ///< Of psi itself: end points lie anywhere inside wall cells [m^2].
};
PARLOC_HD double psi_variance(const FieldMeasurement& z, const PsiNoise& noise) {
  constexpr double kLeast = 1e-12;  // a micrometre: keeps a scan without any slope from dividing by zero
  const double r = noise.range_variance * z.range_slope_sq + noise.floor_variance;
  return r > kLeast ? r : kLeast;
}

/// The scan does not say where to go: every beam is beyond the cap, or off the map, or the field is flat.
PARLOC_HD bool has_slope(const FieldMeasurement& z) {
  return dot(z.slope, z.slope) > 1e-18;
}

/// What the Kalman filter with one innovation per beam is summed from: the upper half of the information
/// matrix, and the information vector (SPEC 8.2).
struct InformationTerms {
  static constexpr int kSums = 9;
  float range_variance = 0.0f;  ///< [cells^2]
  float map_variance = 0.0f;    ///< [cells^2]
  float beta = 1.0f;
  PARLOC_HD BeamTerms<kSums> operator()(const FieldValue& f, const BeamSlopes& s) const {
    const float w = beta / fused(range_variance, s.range * s.range, map_variance);
    const float wx = w * f.slope_x, wy = w * f.slope_y, wt = w * s.turn;
    return {{wx * f.slope_x, wx * f.slope_y, wx * s.turn, wy * f.slope_y, wy * s.turn, wt * s.turn,
             wx * f.distance, wy * f.distance, wt * f.distance}};
  }
};

/// Information of all beams about an error at the pose where they were looked up.
struct ScanInformation {
  Matrix3 matrix;
  Vector3 vector;  ///< matrix * (where the scan pulls to), metres and radians.
};
PARLOC_HD ScanInformation finish_information(const BeamTerms<InformationTerms::kSums>& sum,
                                             const DistanceField& field) {
  // Terms are per cell^2: distances and turns in cells, variances in cells^2.
  const double cell_m = field.resolution_m, per_m2 = 1.0 / (cell_m * cell_m);
  const double t[6] = {sum.v[0], sum.v[1], sum.v[2], sum.v[3], sum.v[4], sum.v[5]};
  ScanInformation s;
  s.matrix(0, 0) = t[0] * per_m2;
  s.matrix(0, 1) = s.matrix(1, 0) = t[1] * per_m2;
  s.matrix(0, 2) = s.matrix(2, 0) = t[2] / cell_m;
  s.matrix(1, 1) = t[3] * per_m2;
  s.matrix(1, 2) = s.matrix(2, 1) = t[4] / cell_m;
  s.matrix(2, 2) = t[5];
  s.vector[0] = -static_cast<double>(sum.v[6]) / cell_m;
  s.vector[1] = -static_cast<double>(sum.v[7]) / cell_m;
  s.vector[2] = -static_cast<double>(sum.v[8]);
  return s;
}

}  // namespace parloc
