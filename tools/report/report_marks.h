// What is drawn over a map of the report, as SVG in the pixels of its view. What cannot be drawn is left out.
#pragma once

#include <cstddef>
#include <string>

#include "tools/report/map_view.h"
#include "tools/report/plots/axis.h"
#include "tools/report/report.h"

namespace parloc::tools {

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

/// Since the start of the axis, in its unit.
std::string time_text(const Axis& axis, double stamp_s);

}  // namespace parloc::tools
