// Where a run starts: --init.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/filter/pose/pose_guess.h"
#include "common/io/trajectory.h"
#include "common/math/pose.h"
#include "common/search/search_config.h"

namespace parloc::tools {

/// A Gaussian about a pose of the map frame, several of them, or anywhere on the map's free cells.
struct StartPose {
  bool anywhere = false;
  Pose pose;
  double sigma_x_m = 0.0, sigma_y_m = 0.0, sigma_theta_rad = 0.0;
  SearchPrior prior{};               ///< Of a start anywhere, for a run that searches.
  std::vector<PoseGuess> guesses{};  ///< Several candidates, equally likely; `pose` is then the first.

  bool known() const { return !anywhere && guesses.empty(); }
};

/// "global", "x,y,theta" or "x,y,theta,sx,sy,st" in metres and radians; sigmas not given come from the
/// configuration. Throws Error{usage} for anything else, for values that are not finite, a theta beyond one
/// turn (degrees?) and sigmas below 0.
StartPose parse_start_pose(const std::string& text, const Config& config);

/// The same for every --init that was given, at least one: several are candidates, each of them a pose, its
/// spread in place the larger of its two.
StartPose parse_start_poses(const std::vector<std::string>& texts, const Config& config);

/// The truth's pose nearest in time to `stamp_s` (the first of equals), with the configuration's sigmas.
/// Throws Error{input} if none is within max_gap_s: the truth is then that of another log.
StartPose start_from_truth(const Trajectory& truth, double stamp_s, const Config& config,
                           double max_gap_s = 1.5);

}  // namespace parloc::tools
