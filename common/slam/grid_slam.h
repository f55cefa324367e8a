// Mapping without a map: a Rao-Blackwellized particle filter whose particles each carry a grid map (GMapping;
// Grisetti, Stachniss and Burgard 2007; SPEC 9).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "common/model/beam_counts.h"
#include "common/model/scan.h"
#include "common/model/trajectory.h"
#include "common/slam/grid_slam_config.h"
#include "common/slam/loops/loop_counts.h"
#include "common/slam/scan_odometry_counts.h"
#include "common/slam/slam_checkpoint.h"

namespace parloc {

/// One scan that was taken in.
struct SlamRecord {
  double stamp_s = 0.0;         ///< The scan's.
  double n_eff = 0.0;           ///< Effective number of particles, before resampling.
  bool resampled = false;       ///< Particles were drawn anew afterwards.
  std::size_t tiles = 0;        ///< In use by all particles together.
  std::size_t handed_over = 0;  ///< Tiles of far places, one for all particles (slam.memory_mib).
};

/// What the maps of all particles take together.
struct SlamMemory {
  std::size_t tile_bytes = 0;       ///< Of the tiles in use now.
  std::size_t most_tile_bytes = 0;  ///< That were ever in use at once.
  std::size_t table_bytes = 0;      ///< Which tile is where, for every particle.
  std::size_t sub_map_bytes = 0;    ///< Of the places that are handed over now; in host memory.
};

/// Draws a map while it finds its way in it. Deterministic: the same configuration and calls give the same
/// bits on every backend, thread count and instruction set. Not thread-safe; trajectory(), map(), loops() and
/// digest() are not either, const as they are.
class GridSlam {
 public:
  /// Throws Error{config} and Error{backend}.
  explicit GridSlam(const GridSlamConfig& config);
  /// Goes on from what save() wrote: the same input then gives the same bits as if there had been no break.
  /// Throws Error{input} for a state that makes no sense, Error{config} if checkpoint.config has become
  /// another in more than backend, threads and device.
  explicit GridSlam(SlamCheckpoint checkpoint);
  ~GridSlam();

  /// Writes everything that is needed to go on from here, `own` beside it for the caller. The file is there
  /// as a whole and on the disk, or is what it was. Throws Error{output}.
  void save(const std::string& path, const std::string& own = {}) const;

  /// A reading between scans, in any order, as PoseFilter takes them.
  void add_odometry(double stamp_s, const Pose& odometry);
  /// Takes a scan in if the robot has moved far enough since the last one that counted; whether it did. The
  /// map frame's origin is where the first scan was taken.
  /// Non-finite odometry is skipped and counted; a scan that scan.check_stamps refuses is skipped. Throws
  /// Error{input} for a scan with numbers that are not finite or arrays that do not fit together. With
  /// slam.odometry `scans` the odometry handed over, here and above, is not looked at.
  bool step(const Pose& odometry, const Scan& scan);
  /// The same with the odometry at the scan's stamp taken from the readings that were added, as PoseFilter
  /// does; skipped where they do not reach there.
  bool step(const Scan& scan);

  /// Slot of the most likely particle.
  std::size_t best() const;
  /// Where the particles were at the last scan that counted, by slot; map frame.
  std::vector<Pose> poses() const;
  /// The best one's pose at every scan so far, map frame; between scans that counted by odometry, bent to fit
  /// both. With slam.close_loops the loops of it are closed first, which takes a while; once, until the next
  /// scan is taken in.
  Trajectory trajectory() const;
  /// Its map, cropped to what is known; with slam.close_loops drawn anew along that trajectory. While it is
  /// being made map_so_far() is quicker: it takes some milliseconds for 600 x 700 cells.
  GridMap map() const;
  /// Closes the loops now, if they are to be closed. `watch` is told how much is done, 0 to 1; what it throws
  /// ends that, as if it had not been asked for.
  void close_loops(const std::function<void(double fraction)>& watch) const;
  /// The same as the particle has it, whatever slam.close_loops says; for pictures on the way.
  Trajectory trajectory_so_far() const;
  /// Likewise its map.
  GridMap map_so_far() const;
  /// SHA-256 over these two, hex.
  std::string digest_so_far() const;
  /// What became of the loops; nothing without slam.close_loops.
  std::optional<LoopCounts> loops() const;
  /// By scan that counted.
  const std::vector<SlamRecord>& records() const;
  /// By scan that counted: how many different poses the particles of now have behind them there.
  std::vector<std::size_t> distinct_ancestors() const;
  /// What the maps take now.
  SlamMemory memory() const;
  /// At every scan from the first that counted on: as recorded, or from the scans.
  Trajectory odometry() const;
  /// What became of the scans; nothing with recorded odometry.
  std::optional<ScanOdometryCounts> scan_odometry() const;
  const std::vector<LidarUse>& lidars_used() const;  ///< By LiDAR, in the order in which they came.
  std::size_t odometry_jumps() const;                ///< Of the steps (ContinuousOdometry), this run's alone.
  std::size_t odometry_invalid() const;              ///< Scans skipped because their odometry was not finite.
  const GridSlamConfig& config() const;              ///< What it was made with.
  std::string backend_name() const;                  ///< As PoseFilter::backend_name().
  std::string digest() const;  ///< SHA-256, hex, of trajectory() and the cells of map().

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
