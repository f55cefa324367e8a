// What a run shows to a person: one HTML file, and one picture.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/eval/metrics.h"
#include "common/filter/particle_filter.h"
#include "common/io/trajectory.h"
#include "common/localize/health.h"
#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "tools/report/plots/plot.h"
#include "tools/report/text/table.h"

namespace parloc::tools {

/// The filter at one moment. All in the map frame.
struct Snapshot {
  struct Point {
    float x_m, y_m;
  };
  double stamp_s = 0.0;
  Pose pose;  ///< The estimate.
  std::vector<Particle>
      particles;  ///< More than Snapshot::max_particles are thinned evenly by slot when drawn.
  std::vector<Point> scan_points;  ///< End points of the scan, seen from the estimate; may be empty.

  static constexpr std::size_t max_particles = 2000;
};

/// One filter step in numbers. A value that is not known is NaN and leaves a gap in its plot.
struct StepRecord {
  double stamp_s = 0.0;
  double n_eff = 0.0;
  double sigma_x_m = 0.0, sigma_y_m = 0.0, sigma_theta_rad = 0.0;  ///< Of the estimate's covariance.
  double step_ms = 0.0;                                            ///< RayWall time of the step.
  bool resampled = false;
  bool lost = false;               ///< Every particle had weight zero.
  double particles = 0.0;          ///< That were weighed.
  double p_injected = 0.0;         ///< Share of the next ones that is drawn from free space.
  std::optional<Health> health{};  ///< Where it is judged.
  bool searched = false;           ///< The map was searched at this step.
};

/// A map at one moment of its making.
struct MapMoment {
  Snapshot state;   ///< When it was, and where the robot and the particles were.
  GridMap map;      ///< As it was then; the grid's heading is that of the report's map.
  Trajectory path;  ///< The way there, as it was believed then.
  Facts facts;      ///< What there is to say.
};

/// Everything a report can show. What is empty (or NaN, or null) is left out; only `title` is needed.
struct RunReport {
  std::string title;         ///< "log.gz on map.yaml"
  std::string command_line;  ///< As typed, for repeating the run.
  Facts summary;             ///< First rows of the first table; the writer adds poses, duration, distance,
                             ///< errors and step times from the data below.
  std::vector<FactTable> details;     ///< Further tables, at the end.
  std::vector<std::string> warnings;  ///< What was worked around, one line each.

  const GridMap* map = nullptr;  ///< Not owned; must outlive the writing.
  Trajectory estimate;
  std::optional<Trajectory> truth;
  Trajectory odometry;                ///< Dead reckoning placed at the start pose, map frame.
  std::optional<TrackErrors> errors;  ///< Of `estimate` against `truth`.

  std::vector<StepRecord> steps;
  double resample_below = 0.0;  ///< N_eff under which is resampled: threshold * particles; 0: not drawn.
  double particles = 0.0;       ///< N, the upper end of the N_eff plot; 0: not known, or not fixed.
  bool adaptive = false;        ///< N changes from step to step: drawn beside N_eff.

  std::vector<Snapshot> snapshots;  ///< In time order; 6 to 12 follow a run well, at most 24 are shown.
  bool every_cloud = false;         ///< The map shows all of them together, not only one moment's.
  std::vector<MapMoment> growth;    ///< In time order, where the map was made in this run; 24 are shown.
  std::string growth_note;          ///< What the words of their facts mean.
  std::vector<Plot> plots;          ///< More plots over time, after that of N_eff.
};

/// One self-contained HTML file: no script, style, font or image from elsewhere; readable on a phone and in
/// dark mode. The map is downsampled to at most 1600 pixels a side (an occupied cell wins), series to at most
/// 1000 columns with their minimum and maximum, so that 15,000 steps stay below 3 MB. Values that are not
/// finite leave gaps. Written to a temporary file beside `path` that is renamed: throws Error{output} and
/// leaves what was there. The same report gives the same bytes.
void write_report(const std::string& path, const RunReport& report);

/// One PNG, the map in it at most 2000 pixels a side: the map around the paths, the odometry, truth and
/// estimated path, the last particle cloud or all of them, start and end, a legend and a scale bar. Throws
/// Error{output} likewise; a report without a map and without a path gives Error{output} as well.
void write_picture(const std::string& path, const RunReport& report);

/// One PNG for looking at while the work goes on, at most 1000 pixels a side and made for speed: the map, the
/// estimated path, the last snapshot's particles, the robot at its pose, and `caption` below. Throws as
/// write_picture().
void write_live_picture(const std::string& path, const RunReport& report, const std::string& caption);

/// One PNG: the errors in x, y and heading over time, one under the other, with three standard deviations of
/// the particles. Throws Error{output} likewise; a report without errors gives Error{output} as well.
void write_error_picture(const std::string& path, const RunReport& report);

}  // namespace parloc::tools
