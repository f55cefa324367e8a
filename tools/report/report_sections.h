// The pieces that write_report() and the pages of other commands are put together from.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/report/map_view.h"
#include "tools/report/plots/axis.h"
#include "tools/report/report.h"

namespace parloc::tools {

/// So many pictures of a run are drawn at most, evenly spread over it.
inline constexpr std::size_t kMostMoments = 24;

/// The style sheet: light and dark, any width. Classes c1 to c6 are the colours of lines and marks.
const char* report_style();

/// The script that moves particle cloud and growing map through time; without it the last moment is shown.
const char* report_script();

/// The map with the paths and, one at a time, the particle clouds; then a close-up of each cloud.
/// `axis` gives the time of each moment. Empty if there is neither a map nor a path.
std::string map_figures(const RunReport& report, const Axis& axis);

/// A map in the making: one large picture at a time, what was known of it, and all of them small. `view` is
/// that of the finished map. Empty without such moments.
std::string growth_figures(const RunReport& report, const MapView& view, const Axis& axis);

/// The cells under the view as a PNG. Free cells are clear, so that the page's own colour shows.
std::string map_data_uri(const GridMap& map, const MapView& view);
/// The cells as an <image> for an <svg> of the view's size.
std::string map_image(const GridMap& map, const MapView& view);
/// Once per page with such images: inverts their colours in dark mode. As an SVG filter, because not every
/// browser applies CSS filter functions inside SVG.
const char* invert_filter();
/// What is drawn over a map, with a scale bar, in a frame that is never higher than `most_vh` % of the
/// window.
std::string map_frame(const MapView& view, const char* label, const std::string& drawing,
                      double most_vh = 85.0);
/// An entry of a legend: `mark` is the kind and the colour of its sample.
std::string legend_key(const std::string& mark, const std::string& label);

/// The plots of errors, N_eff, standard deviations and step time, as far as there are data.
std::string plot_figures(const RunReport& report, const Axis& axis);

/// The errors in x, y and heading; empty without a truth.
std::vector<Plot> error_plots(const RunReport& report);

/// The rows of the first table: the caller's, then what follows from the data.
Facts summary_facts(const RunReport& report);

/// At most `most` of `count` indices, evenly spaced, with the first and the last.
std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most);

/// The pose at the time closest to `stamp_s`; null if the trajectory is empty.
const StampedPose* nearest_pose(const Trajectory& trajectory, double stamp_s);

// Marks over a map, as SVG in the pixels of its view. What cannot be drawn is left out.

/// A <path>; empty without points.
std::string svg_path(const std::string& classes, const std::string& d);

struct PathDetail {
  std::size_t most_points;
  double least_px;  ///< Points that are closer than this to the one before are left out.
};
/// The points of a <path> along the poses. Poses that cannot be drawn break it.
std::string track_path(const Trajectory& track, const MapView& view, const PathDetail& detail);

/// The particles as dots, in three strengths by weight.
std::string cloud(const Snapshot& snapshot, const MapView& view, const std::string& id);
/// An arrow from the pose along its heading.
std::string arrow(const Pose& pose, const MapView& view, double length_px);
std::string dot(const std::string& classes, const Pose& pose, const MapView& view);

/// Opens the group of what is drawn of one moment, for the script to show and to hide.
std::string moment_group(const char* kind, double stamp_s, const Axis& axis, bool shown);
/// Since the start of the axis, in its unit.
std::string time_text(const Axis& axis, double stamp_s);

/// From <!DOCTYPE> to the command that made the page. `style` is added to report_style().
std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style = "");

}  // namespace parloc::tools
