// Makes a map from a log: one step per scan, and everything that is worth knowing about it afterwards.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/map/grid_map.h"
#include "common/model/beam_counts.h"
#include "common/model/lidar.h"
#include "common/slam/grid_slam.h"
#include "tools/program/scan_times.h"
#include "tools/slam/growth.h"

namespace parloc::tools::slam {

struct MapRequest {
  Config config;
  std::string log_name;                                              ///< For messages.
  std::function<void(double fraction, std::size_t scans)> progress;  ///< After every scan; may be empty.
  std::function<void(const LogWarnings&)>
      read;  ///< After every record; may be empty: for notes as they come.
  /// After every scan that was taken in; may be empty. `scans` were read.
  std::function<void(const GridSlam& slam, std::size_t scans)> watch;
  bool odometry_chosen = false;                  ///< From the scans, since the recorded one never moves.
  std::function<void(double fraction)> closing;  ///< While loops are closed; may be empty.
  /// Asked before every scan, and while loops are closed; may be empty. True ends the work early.
  std::function<bool()> stop;
  std::string checkpoint;            ///< Where the state is written when the work ends early; empty: nowhere.
  double checkpoint_every_s = 0.0;   ///< How often besides, of wall time [s]; 0: not.
  SlamCheckpoint* resume = nullptr;  ///< Goes on from there, with `config`; the log from its beginning.
};

struct Mapping {
  GridMap map;  ///< Of the most likely particle.
  Trajectory
      trajectory;  ///< Its path: one row per scan, in file order. Origin: where the first scan was taken.
  Trajectory odometry;                ///< Dead reckoning from there, or by the scans.
  std::vector<SlamRecord> records;    ///< One per scan that was taken in.
  std::vector<std::size_t> distinct;  ///< Ancestors of the last particles, by such a scan.
  std::vector<double> step_s;         ///< RayWall time of each of them.
  std::vector<Growth> growth;         ///< Evenly over such scans, 23 at most, the last one among them.
  std::size_t scans = 0;              ///< Read from the log.
  std::size_t resumed_at = 0;         ///< So many of these were done before the checkpoint.
  SlamMemory memory;
  std::optional<std::size_t> resident_bytes;  ///< Of the program, at most; where the system says so.
  std::vector<LidarUse> lidars;
  LogWarnings warnings;
  std::size_t odometry_jumps = 0;  ///< Of the scans since it was resumed, if it was.
  ScanTimes times;
  std::optional<ScanOdometryCounts> scan_odometry;  ///< Nothing with recorded odometry.
  bool odometry_chosen = false;                     ///< From the scans, since the recorded one never moves.
  std::optional<LoopCounts> loops;                  ///< Nothing where they were left open.
  Config config;
  std::string backend, digest;
  double wall_s = 0.0, log_s = 0.0;
  bool interrupted = false;

  double real_time_factor() const { return wall_s > 0.0 ? log_s / wall_s : 0.0; }
};

/// Deterministic but for the times, with or without a break. Ended before a scan was taken in it has no map.
/// Throws Error{input} for a log without a scan that can be used, and for one that is not the checkpoint's;
/// Error{config} and Error{backend} as GridSlam.
Mapping map_log(LogReader& log, const MapRequest& request);

}  // namespace parloc::tools::slam
