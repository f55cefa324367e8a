// How far an estimated trajectory is from the truth (SPEC 10).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/io/trajectory.h"

namespace parloc {

/// Errors of an estimate against the truth. All in metres and radians; the 2-D norm for position.
struct TrackErrors {
  std::size_t compared = 0;       ///< Estimates that had a truth.
  std::size_t without_truth = 0;  ///< Estimates that had none within the gap.
  double position_rmse_m = 0;     ///< Root of the mean square.
  double position_mae_m = 0;      ///< Mean.
  double position_max_m = 0;      ///< Largest.
  double position_p95_m = 0;      ///< 95 of 100 are at most this.
  double heading_rmse_rad = 0;    ///< Root of the mean square.
  double heading_mae_rad = 0;     ///< Mean size.
  double heading_max_rad = 0;     ///< Largest size.
  double x_rmse_m = 0;            ///< Root of the mean square along the map's x axis.
  double y_rmse_m = 0;            ///< And along its y axis.
  // Per compared estimate.
  std::vector<double> stamp_s;            ///< Its time.
  std::vector<double> x_error_m;          ///< Estimate less truth, along the map's x axis.
  std::vector<double> y_error_m;          ///< And along its y axis.
  std::vector<double> position_error_m;   ///< Distance to the true place.
  std::vector<double> heading_error_rad;  ///< Estimate less truth, in [-pi, pi).
};

/// The truth at the stamp of each estimate: the row of the exact stamp if there is one, else interpolated
/// between the rows around it in time order when they are at most max_gap_s apart (x, y linear; heading along
/// the shortest arc).
TrackErrors compare_tracks(const Trajectory& estimate, const Trajectory& truth, double max_gap_s = 1.5);

/// The truth at each stamp, by the same rule; nothing where there is none.
std::vector<std::optional<Pose>> truth_at(const Trajectory& truth, const std::vector<double>& stamps_s,
                                          double max_gap_s = 1.5);

/// One relation: the pose at stamp_2 in the frame of the pose at stamp_1.
struct Relation {
  double stamp_1_s = 0;  ///< Time of the first pose.
  double stamp_2_s = 0;  ///< Time of the second.
  Pose delta;            ///< The second as the first sees it.
};
/// "t1 t2 dx dy dz roll pitch yaw" per line. Throws Error{input} with file:line, and for a file without a
/// relation.
std::vector<Relation> read_relations(const std::string& path);

/// One relation against the estimate.
struct RelationError {
  double stamp_1_s = 0;      ///< Time of the first pose.
  double stamp_2_s = 0;      ///< Time of the second.
  Pose pose_1;               ///< The first, as estimated.
  Pose pose_2;               ///< The second, as estimated.
  double translation_m = 0;  ///< Length of the error.
  double rotation_rad = 0;   ///< Size of its rotation.
};

/// Sizes of the errors: mean, population standard deviation, root of the mean square, median, largest.
struct RelationErrors {
  std::size_t compared = 0;         ///< Relations with both poses.
  std::size_t without_pose = 0;     ///< Relations for which the estimate lacks one.
  std::size_t repeated_stamps = 0;  ///< Poses with the stamp of an earlier one, which is the one compared.
  double translation_mean_m = 0;    ///< Of the lengths.
  double translation_std_m = 0;     ///< Of the lengths.
  double translation_rmse_m = 0;    ///< Of the lengths.
  double translation_median_m = 0;  ///< Of the lengths.
  double translation_max_m = 0;     ///< Of the lengths.
  double rotation_mean_rad = 0;     ///< Of the rotations.
  double rotation_std_rad = 0;      ///< Of the rotations.
  double rotation_rmse_rad = 0;     ///< Of the rotations.
  double rotation_median_rad = 0;   ///< Of the rotations.
  double rotation_max_rad = 0;      ///< Of the rotations.
  std::vector<RelationError> each;  ///< Per compared relation.
};
/// Kuemmerle et al. 2009: ((x_j - x_i) - delta_ij), stamps matched exactly to 6 decimals.
RelationErrors compare_relations(const Trajectory& estimate, const std::vector<Relation>& relations);

}  // namespace parloc
