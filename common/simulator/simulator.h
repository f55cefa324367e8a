// Simulates a drive: a log with noise as a robot would record it, and the exact truth beside it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"

namespace parloc {

/// Where a simulated ray ends.
struct SimulatedHit {
  double range_m =
      0.0;  ///< Distance to the near face of the cell, or to the wall; the maximum if nothing was hit.
  int i = 0, j = 0;  ///< The cell, if a cell was hit.
  bool hit = false;
};

/// Exact traversal in float64 (Amanatides & Woo 1987, crossings recomputed from the integer index, ties step
/// y; SPEC 2.2), written apart from the filter's casters on purpose: a simulation must not share their
/// mistakes. Only occupied cells stop a ray. From inside one: (0, hit). From outside the grid, or leaving it:
/// no hit. Where the map's walls are segments, those stop it instead. (x, y) and the angle are in the map
/// frame.
SimulatedHit cast_simulated_ray(const GridMap& map, double x_m, double y_m, double angle_rad,
                                double range_max_m);

struct SimulatedLog {
  std::vector<LogRecord>
      records;       ///< Scans (with the odometry at their time) and, between them, odometry readings.
  Trajectory truth;  ///< Of the base in the map frame: one pose per stamp at which there is a scan.
  double path_length_m = 0.0;
  double duration_s = 0.0;
  std::size_t beams = 0;  ///< All beams of all scans: hits + over_range + dropouts.
  std::size_t hits = 0;
  std::size_t over_range = 0;  ///< No wall in reach.
  std::size_t unmapped = 0;    ///< Of the hits, those on something that is not on the map.
  std::size_t dropouts = 0;    ///< Lost by chance, or closer than the minimum range.
};

/// Simulates the whole drive. With a scan time, every beam is cast from where the robot is at its own time
/// (before the start and after the end it stands still). Stamps are multiples of 5 ms from 0. The odometry
/// moves once per odometry step with the noise of SPEC 1.2; ranges are Gaussian around the exact ones. Random
/// numbers are Philox streams 10 (odometry, by step) and 11 (beams, by beam, scan and LiDAR), so every beam
/// and step has its own: equal scenarios and seeds give equal bytes on every machine. `keep_going`, if given,
/// is told the fraction done after every scan; false ends the drive. Throws Error{config} for rates that are
/// no multiples of each other or of 5 ms, or for more than 50 million ranges; Error{input} if the path leaves
/// the map or goes through a wall.
SimulatedLog simulate(const Scenario& scenario, const GridMap& map,
                      const std::function<bool(double fraction)>& keep_going = {});

/// The log as CARMEN text: scans as ROBOTLASER lines, odometry between them as ODOM lines.
std::string carmen_text(const SimulatedLog& log);

}  // namespace parloc
