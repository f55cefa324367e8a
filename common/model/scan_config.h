// Settings of the LiDARs: which beams of a scan are used, and what their values mean.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace parloc {

/// What a range of exactly 0 means.
enum class ZeroPolicy {
  invalid,  ///< A broken beam.
  miss,     ///< Nothing within range.
};
/// Which beam of a scan its stamp is the time of.
enum class StampAt { first, middle, last };
/// Which beams of a scan are used, and what their values mean (SPEC 0.3).
struct ScanConfig {
  int max_beams = 100;                           ///< Evenly spaced in angle.
  int min_beams = 5;                             ///< Fewer usable beams: prediction only.
  double laser_min_range = 0.1;                  ///< Used where the log gives none [m].
  double laser_max_range = 40.0;                 ///< Used where the log gives none [m].
  ZeroPolicy zero_policy = ZeroPolicy::invalid;  ///< What a range of 0 means.
  double scan_time = 0.0;             ///< From the first beam to the last, where the log does not say [s].
  StampAt stamp_at = StampAt::first;  ///< As in ROS.
  /// Of one LiDAR's scans, refuse one with the stamp of the last or of the newest (it came twice), and one
  /// that is more than 2 s older than the newest (its odometry is no longer remembered), unless three of
  /// those in a row show that the clock was set back. For a robot; logs are taken as they are.
  bool check_stamps = false;
};

/// From one angle counter-clockwise to another, both included: [3.0, -3.0] crosses the back [rad].
struct AngleInterval {
  double from = 0.0;  ///< Where it begins.
  double to = 0.0;    ///< Where it ends.
};

/// What the log does not say of one LiDAR, or says wrongly. What is empty is as the log says, then as
/// ScanConfig does.
struct LidarConfig {
  std::string name;                    ///< As the log calls it (Scan::sensor).
  std::optional<double> x{};           ///< Place on the robot, ahead [m],
  std::optional<double> y{};           ///< and to the left [m].
  std::optional<double> yaw{};         ///< Where its angle 0 looks [rad].
  std::optional<bool> upside_down{};   ///< Mirrored about its own x axis: angles run the other way.
  std::optional<bool> flipped{};       ///< CARMEN's word for the same thing.
  std::optional<double> angle_min{};   ///< Where its first beam looks [rad].
  std::optional<double> angle_step{};  ///< From beam to beam [rad].
  /// Beams that see the robot itself: never used. Angles as it is mounted: counter-clockwise from its x axis.
  std::vector<AngleInterval> mask{};
  std::optional<double> min_range{};        ///< Shortest range [m].
  std::optional<double> max_range{};        ///< Longest range [m].
  std::optional<int> max_beams{};           ///< As ScanConfig::max_beams.
  std::optional<ZeroPolicy> zero_policy{};  ///< What a range of 0 means.
  std::optional<double> scan_time{};        ///< From the first beam to the last [s].
  std::optional<StampAt> stamp_at{};        ///< Which beam the stamp is the time of.
};

}  // namespace parloc
