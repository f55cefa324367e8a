// Settings of the global search, and what may be known beforehand of where the robot is.
#pragma once

#include <optional>

namespace parloc {

/// Settings of a search of the whole map.
struct SearchConfig {
  /// Cells of the search are at least this large: finer cells of the map are put together [m].
  double cell_m = 0.05;
  double sigma_m = 0.12;         ///< How fast an end point's value falls with its distance to a wall.
  int beams = 60;                ///< Hits that the exhaustive part looks at, 1 to 256; all count afterwards.
  double heading_cells = 1.5;    ///< The farthest end point moves at most so far from heading to heading.
  int max_headings = 1440;       ///< But there are no more headings than this; at least 72.
  double least_score = 0.4;      ///< A pose below it is no hypothesis, of 1.
  double least_share = 0.8;      ///< Nor is one below this share of the best score.
  double separation_m = 1.0;     ///< Hypotheses differ by as much in place, or in heading.
  double separation_rad = 0.35;  ///< As separation_m, for the heading.
  int candidates = 300;          ///< Separated lattice poses that rays are cast for.
  int most = 10;                 ///< Hypotheses in the answer.
  double effective_beams = 6.0;  ///< Independent beams that a scan is worth: how sharply weights differ.
  double ambiguous_share = 0.1;  ///< A weight above this share of the best is as good as equal.
};

/// What is known of the pose beforehand, in the map frame. What is empty may be anything.
struct SearchPrior {
  /// A round part of the map.
  struct Disc {
    double x_m;       ///< Its middle, along the map's x axis.
    double y_m;       ///< And along its y axis.
    double radius_m;  ///< So far around.
  };
  /// Headings to both sides of one.
  struct Interval {
    double heading_rad;    ///< The middle one.
    double tolerance_rad;  ///< So far to either side.
  };
  std::optional<Disc> region{};       ///< Where the robot is.
  std::optional<Interval> heading{};  ///< Where it looks.
};

}  // namespace parloc
