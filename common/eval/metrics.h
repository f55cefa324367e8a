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
  double position_rmse_m = 0, position_mae_m = 0, position_max_m = 0, position_p95_m = 0;
  double heading_rmse_rad = 0, heading_mae_rad = 0, heading_max_rad = 0;
  double x_rmse_m = 0, y_rmse_m = 0;
  std::vector<double> stamp_s, x_error_m, y_error_m, position_error_m,
      heading_error_rad;  ///< Per compared estimate.
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
  double stamp_1_s = 0, stamp_2_s = 0;
  Pose delta;
};
/// "t1 t2 dx dy dz roll pitch yaw" per line. Throws Error{input} with file:line, and for a file without a
/// relation.
std::vector<Relation> read_relations(const std::string& path);

/// One relation against the estimate.
struct RelationError {
  double stamp_1_s = 0, stamp_2_s = 0;
  Pose pose_1, pose_2;  ///< As estimated.
  double translation_m = 0, rotation_rad = 0;
};

/// Sizes of the errors: mean, population standard deviation, root of the mean square, median, largest.
struct RelationErrors {
  std::size_t compared = 0, without_pose = 0;
  std::size_t repeated_stamps = 0;  ///< Poses with the stamp of an earlier one, which is the one compared.
  double translation_mean_m = 0, translation_std_m = 0, translation_rmse_m = 0, translation_median_m = 0,
         translation_max_m = 0;
  double rotation_mean_rad = 0, rotation_std_rad = 0, rotation_rmse_rad = 0, rotation_median_rad = 0,
         rotation_max_rad = 0;
  std::vector<RelationError> each;  ///< Per compared relation.
};
/// Kuemmerle et al. 2009: ((x_j - x_i) - delta_ij), stamps matched exactly to 6 decimals.
RelationErrors compare_relations(const Trajectory& estimate, const std::vector<Relation>& relations);

}  // namespace parloc
