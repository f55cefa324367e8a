// Settings of grid SLAM (SPEC 9).
#pragma once

#include <cstddef>
#include <cstdint>

namespace parloc {

/// Of a scan: so many fit a cell's counters (common/slam/matching/tiles.h).
constexpr std::size_t kMostSlamBeams = 1024;

/// Where a particle's next pose comes from (SPEC 9.3).
enum class SlamProposal {
  motion,      ///< Drawn from the odometry alone.
  scan_match,  ///< Drawn from the odometry, then the best fit near it (what GMapping does).
  gaussian,    ///< Drawn from a Gaussian around the best fit, by scan and odometry (Grisetti et al. 2007).
};

/// What moves the particles between scans.
enum class SlamOdometry {
  recorded,  ///< The readings that are handed over.
  scans,     ///< Each scan matched to the last ones (ScanOdometry); readings are not looked at.
};

/// Settings of mapping.
struct SlamConfig {
  std::int64_t particles = 30;                       ///< Each with a map of its own.
  SlamProposal proposal = SlamProposal::scan_match;  ///< Where a particle's next pose comes from.
  SlamOdometry odometry = SlamOdometry::recorded;    ///< What moves the particles between scans.
  double resolution = 0.05;                          ///< Cell size [m].
  /// So far a beam that saw nothing within its LiDAR's range clears its way [m]; 0: it says nothing.
  double clear_range = 0.0;
  double usable_range = 30.0;         ///< Beams are cut here: farther ends are not matched or drawn [m].
  double resample_threshold = 0.5;    ///< Resample when N_eff < threshold * N; 1 or more: every scan.
  double beta_weight = 0.005;         ///< Exponent of a scan's likelihood in the weights.
  double beta_proposal = 1.0;         ///< The same in the Gaussian proposal.
  double search_xy = 0.0;             ///< Before it climbs, the matcher searches so far around [m].
  double search_theta = 0.0;          ///< And so far in heading [rad]; both 0: it only climbs.
  double search_bias = 0.25;          ///< Score per beam that a pose at its rim must have more.
  double step_xy = 0.05;              ///< First step of the scan matcher [m].
  double step_theta = 0.05;           ///< The same in heading [rad].
  int iterations = 7;                 ///< Times that it halves its steps.
  double sigma_score = 0.01;          ///< Of the matcher's score: exp(-d^2 / sigma) [m^2].
  double sigma_likelihood = 0.075;    ///< Of a beam's likelihood: -d^2 / sigma [m^2].
  double min_score = 0.1;             ///< Score per beam below which matching has failed.
  double box_xy = 0.06;               ///< Half the box of the Gaussian proposal [m].
  double box_theta = 0.04;            ///< The same in heading [rad].
  double motion_floor_xy = 0.01;      ///< Motion noise besides, whatever the motion [m].
  double motion_floor_theta = 0.003;  ///< The same in heading [rad].
  double occupied_above = 0.25;       ///< Share of hits from which a cell of the written map is a wall.
  bool close_loops = true;            ///< Trajectory and map with loops closed afterwards (close_loops.h).
  int memory_mib = 0;  ///< Most that the tiles of all particles take [MiB]; 0: no limit (sub_maps.h).
};

}  // namespace parloc
