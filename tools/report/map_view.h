// Which part of the map a report shows, and where a point of the map frame lies in that image.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/map/grid_map.h"
#include "tools/report/pictures/pixel.h"
#include "tools/report/report.h"

namespace parloc::tools {

/// A window of a grid as an image: pixels are `down` cells wide, or 1 / `up` cells (one of the two is 1).
/// The image stands upright in the grid's frame; without a map, in the map frame on a grid made up for it.
struct MapView {
  Pose T_map_grid;
  double cell_m = 1.0;
  std::int64_t first_i = 0, first_j = 0;  ///< Lower-left cell of the window; may lie outside the grid.
  std::int64_t down = 1;
  std::int32_t up = 1;
  std::int32_t width_px = 1, height_px = 1;

  double pixel_m() const { return cell_m * static_cast<double>(down) / static_cast<double>(up); }
  Pixel to_pixel(double x_m, double y_m) const;
  /// Angle of a heading in the image, counter-clockwise from right.
  double to_image_angle(double theta_rad) const { return theta_rad - T_map_grid.theta_rad; }
};

/// The window around the estimated and true paths and, within reason, the odometry; the whole known map when
/// there is no path. At most `most_px` pixels a side; cells are magnified when the longer side would be
/// below `least_px`. Nothing if there is nothing to show. Throws Error{output} if the map's size and cells
/// disagree.
std::optional<MapView> fit_view(const RunReport& report, std::int32_t least_px, std::int32_t most_px);

/// Throws Error{output} naming `path`, what is to be written, if there is nothing to show.
MapView view_to_write(const std::string& path, const RunReport& report, std::int32_t least_px,
                      std::int32_t most_px);

/// The cells in the window, one per pixel, row 0 at the top. An occupied cell wins over all others in its
/// pixel, else the more frequent of free and unknown.
std::vector<Cell> raster(const GridMap& map, const MapView& view);

/// The longest of 1, 2, 5, 10, ... metres (or a fraction) that is at most a fifth of the image's width.
double scale_bar_m(const MapView& view);

/// Whether a pose can be drawn: finite and within 10,000 km.
bool drawable_point(double x_m, double y_m);

}  // namespace parloc::tools
