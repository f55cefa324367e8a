// What a simulated drive is made of: a map, a path, one or several LiDARs and the errors of the odometry.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "common/model/motion_config.h"
#include "common/model/scan_config.h"

namespace parloc {

/// A point of the map frame that the robot drives to.
struct Waypoint {
  double x_m = 0.0;
  double y_m = 0.0;
  double pause_s = 0.0;   ///< It stands still this long after it arrives, before it turns.
  double spin_rad = 0.0;  ///< Then it turns in place by this, whole turns included, left if positive.
};

/// The robot drives straight from point to point and stops to turn in place (the experiment of Paz et al.
/// 2012).
struct WaypointPath {
  std::string name;  ///< The file it came from, for messages.
  std::vector<Waypoint> points;
  double speed_mps = 0.5;
  double turn_rate_rad_s = 0.5;
};

/// What a LiDAR reports for a beam that it lost.
enum class DropoutValue { zero, nan, inf };
/// What a LiDAR reports for a beam without a wall in reach: its maximum, infinity, or a code such as 81.83.
enum class OverRange { max, inf, code };

struct SimulatedLidar {
  int beams = 361;
  double angle_min_rad = -1.5707963267948966;
  double angle_step_rad = 0.008726646259971648;  ///< 0.5 degrees.
  double range_min_m = 0.1;
  double range_max_m = 8.0;
  double sigma_range_m = 0.02;        ///< Standard deviation of a range.
  double sigma_range_relative = 0.0;  ///< Share of the range that is added to it.
  double dropout_probability = 0.0;
  DropoutValue dropout_value = DropoutValue::zero;
  OverRange over_range = OverRange::max;
  double over_range_code_m = 81.83;
  Pose T_base_sensor;
  bool upside_down = false;  ///< Mirrored about its own x axis. A log cannot say so.
  double scan_time_s = 0.0;  ///< From the first beam to the last; each sees from where the robot is then.
  StampAt stamp_at = StampAt::first;
  double delay_s = 0.0;  ///< Its scans are this much later than those of a LiDAR without.
};

/// How the odometry errs.
enum class OdometryErrors {
  motion_model,  ///< As the filters' motion model has it: turn, drive, turn (SPEC 1.2).
  wheels,        ///< As two wheels do (common/simulator/wheel_odometry.h).
};

struct SimulatedOdometry {
  double rate_hz = 20.0;
  OdometryErrors errors = OdometryErrors::motion_model;
  /// Only form and alpha1..alpha4 (SPEC 1.2), applied once per odometry step. The robot's own: not the
  /// filter's defaults.
  MotionConfig noise{.alpha1 = 0.1, .alpha2 = 0.05, .alpha3 = 0.1, .alpha4 = 0.05};
  double kappa_m = 1e-4;           ///< wheels: variance of a wheel's distance per distance.
  double wheel_base_m = 0.16;      ///< wheels: between the two.
  double scale_translation = 1.0;  ///< Wrong wheel radius.
  double scale_rotation = 1.0;     ///< Wrong wheel base.
  double drift_rad_per_m = 0.0;    ///< Unequal wheels.
  double delay_s = 0.0;            ///< What it says was true so much earlier.
  Pose start;                      ///< Pose of the odometry when the drive begins, in the odometry frame.
};

/// Things that are on no map. Boxes stand beside the path; people walk with the robot, all around it, and go
/// through walls (a wall hides who is behind it).
struct SimulatedClutter {
  int boxes = 0;
  double box_min_m = 0.3, box_max_m = 1.0;  ///< Length and width.
  double box_reach_m = 3.0;                 ///< At most so far from the path.
  double clearance_m = 0.4;                 ///< At least so far from it.
  int people = 0;
  double person_radius_m = 0.25;
  double person_min_m = 0.7, person_max_m = 3.0;  ///< From the robot.
};

struct Scenario {
  std::string map_path;               ///< What rays are cast against.
  std::string localization_map_path;  ///< The coarser map for the filter; empty if the scenario names none.
  std::string path_file;
  WaypointPath path;  ///< What path_file holds.
  std::uint64_t seed = 1;
  double scan_rate_hz = 10.0;
  SimulatedLidar lidar;                     ///< robotlaser1 of the log.
  std::vector<SimulatedLidar> more_lidars;  ///< robotlaser2 and so on, at most 8.
  SimulatedOdometry odometry;
  SimulatedClutter clutter;
};

/// Reads a scenario and its path; the files it names are relative to its own folder, or begin with $NAME: a
/// folder that the environment names. Angles are in degrees there. Throws Error{config} with file:line for an
/// unknown key (naming the nearest valid one), a duplicate, a wrong type or a value outside its limits, in
/// the scenario or in its path file.
Scenario read_scenario(const std::string& yaml_path);
/// The same from memory, but opens no file: the path stays empty. `name` stands for the file and gives the
/// folder.
Scenario scenario_from_text(const std::string& text, const std::string& name);

WaypointPath read_waypoints(const std::string& yaml_path);
WaypointPath waypoints_from_text(const std::string& text, const std::string& name);

}  // namespace parloc
