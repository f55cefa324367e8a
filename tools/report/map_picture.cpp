#include "tools/report/map_picture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/pixel.h"
#include "tools/report/plots/plot.h"
#include "tools/report/report.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr std::int32_t least_live_px = 600, most_live_px = 1000;
constexpr Rgba pale_walls = {182, 188, 196, 255}, pale_discs = {130, 136, 144, 255};
constexpr std::size_t most_ends = 500;  // more would hide the walls

/// The cells, occupied ones in `occupied`. The canvas has the size of the view.
void draw_cells(Canvas& canvas, const GridMap& map, const MapView& view, Rgba occupied) {
  const std::vector<Cell> cells = raster(map, view);
  std::size_t next = 0;
  canvas.paint(view.width_px, view.height_px, [&](std::int32_t, std::int32_t) {
    const Cell cell = cells[next++];
    return cell == Cell::occupied ? occupied : cell == Cell::free ? white : unknown_colour;
  });
}

/// In the lower left corner of the map, on a pale plate so that it can be read on walls.
void draw_scale_bar(Canvas& canvas, const MapView& view) {
  const double length_m = scale_bar_m(view);
  const double length_px = length_m / view.pixel_m();
  const std::string label = number_text(length_m, 4) + " m";
  const double wide = std::max(length_px, canvas.text_width(label));
  const double left = margin_px, bottom = view.height_px - margin_px;
  canvas.rectangle(left - 8, bottom - 32, left + wide + 8, bottom + 8, {255, 255, 255, 220});
  canvas.rectangle(left, bottom - 4, left + length_px, bottom, ink);
  canvas.text({left + wide / 2, bottom - 18}, label, ink, Anchor::middle);
}

void draw_walls(Canvas& canvas, const GridMap& map, const MapView& view) {
  const auto pixel = [&](float x_m, float y_m) {
    const Pose p = compose(map.T_map_grid, {x_m, y_m, 0.0});
    return view.to_pixel(p.x_m, p.y_m);
  };
  const bool with_ends = map.walls.size() <= most_ends;
  for (const GridWall& wall : map.walls) {
    const Pixel a = pixel(wall.ax, wall.ay), b = pixel(wall.bx, wall.by);
    canvas.line({a, b}, 2.5, estimate_colour);
    if (!with_ends) continue;
    canvas.disc(a, 3.5, truth_colour);
    canvas.disc(b, 3.5, truth_colour);
  }
}

void draw_scan(Canvas& canvas, const MapView& view, const Pose& pose, const std::vector<EndPoint>& ends) {
  for (const EndPoint& end : ends) {
    const Pose p = compose(pose, {end.x_m, end.y_m, 0.0});
    if (!drawable_point(p.x_m, p.y_m)) continue;
    canvas.disc(view.to_pixel(p.x_m, p.y_m), 3.5, truth_colour);
  }
}

void draw_hypothesis(Canvas& canvas, const MapView& view, const Hypothesis& h, std::size_t number) {
  const Rgba colour = !h.as_good ? pale_discs : number == 1 ? estimate_colour : odometry_colour;
  const Pixel at = view.to_pixel(h.pose.x_m, h.pose.y_m);
  const double angle = view.to_image_angle(h.pose.theta_rad), length_px = 30;
  const Pixel tip = {at.x + length_px * std::cos(angle), at.y - length_px * std::sin(angle)};
  canvas.line({at, tip}, 9, white);
  canvas.line({at, tip}, 5, colour);
  canvas.disc(at, 15, white);
  canvas.disc(at, 13, colour);
  canvas.text(at, std::to_string(number), white, Anchor::middle);
}

/// A solid line, or dashes of `dash_px` with gaps as long (0: solid).
void draw_track(Canvas& canvas, const Trajectory& track, const MapView& view, double width_px, double dash_px,
                Rgba colour) {
  std::vector<Pixel> piece;
  const auto draw = [&] {
    if (piece.size() > 1) canvas.line(piece, width_px, colour, dash_px);
    piece.clear();
  };
  for (const StampedPose& p : track) {
    if (!drawable_point(p.pose.x_m, p.pose.y_m)) {
      draw();
      continue;
    }
    const Pixel to = view.to_pixel(p.pose.x_m, p.pose.y_m);
    // Closer points would only cost time: a robot may stand still for long.
    if (piece.empty() || std::hypot(to.x - piece.back().x, to.y - piece.back().y) >= 0.7) piece.push_back(to);
  }
  draw();
}

void draw_particles(Canvas& canvas, const Snapshot& snapshot, const MapView& view) {
  const std::vector<Particle>& particles = snapshot.particles;
  for (const std::size_t k : evenly_spaced(particles.size(), Snapshot::max_particles)) {
    if (!drawable_point(particles[k].x_m, particles[k].y_m)) continue;
    canvas.disc(view.to_pixel(particles[k].x_m, particles[k].y_m), 1.6, particle_colour);
  }
}

void draw_clouds(Canvas& canvas, const RunReport& report, const MapView& view) {
  if (report.snapshots.empty()) return;
  if (report.every_cloud) {
    for (const Snapshot& snapshot : report.snapshots) draw_particles(canvas, snapshot, view);
  } else {
    draw_particles(canvas, report.snapshots.back(), view);
  }
}

void draw_ring(Canvas& canvas, Pixel at) {
  canvas.disc(at, 8, estimate_colour);
  canvas.disc(at, 4.5, white);
}

void draw_square(Canvas& canvas, Pixel at) {
  canvas.rectangle(at.x - 8, at.y - 8, at.x + 8, at.y + 8, white);
  canvas.rectangle(at.x - 6.5, at.y - 6.5, at.x + 6.5, at.y + 6.5, estimate_colour);
}

void draw_start_and_end(Canvas& canvas, const Trajectory& track, const MapView& view) {
  if (track.empty()) return;
  const Pose &first = track.front().pose, &last = track.back().pose;
  if (drawable_point(first.x_m, first.y_m)) draw_ring(canvas, view.to_pixel(first.x_m, first.y_m));
  if (drawable_point(last.x_m, last.y_m)) draw_square(canvas, view.to_pixel(last.x_m, last.y_m));
}

/// Clouds of centimetres are smaller than the mark of the end, clouds of metres hide the paths.
void draw_paths_and_clouds(Canvas& canvas, const RunReport& report, const MapView& view) {
  if (report.every_cloud) draw_clouds(canvas, report, view);
  if (report.truth) draw_track(canvas, *report.truth, view, 7, 0, truth_colour);
  draw_track(canvas, report.estimate, view, 3, 0, estimate_colour);
  draw_track(canvas, report.odometry, view, 2.5, 9, odometry_colour);
  draw_start_and_end(canvas, report.estimate, view);
  if (!report.every_cloud) draw_clouds(canvas, report, view);
}

/// What a mark means: its sample is drawn 38 pixels wide, from `at` on.
struct Key {
  const char* label;
  std::function<void(Canvas& canvas, Pixel at)> draw;
};

std::vector<Key> legend_keys(const RunReport& report) {
  const auto line = [](double width, Rgba colour, double dash_px) {
    return [=](Canvas& canvas, Pixel at) {
      canvas.line({{at.x + 3, at.y}, {at.x + 35, at.y}}, width, colour, dash_px);
    };
  };
  const auto particles = [](Canvas& canvas, Pixel at) {
    for (int k = 0; k < 5; ++k)
      canvas.disc({at.x + 5 + 7 * k, at.y + (k % 2 == 0 ? 2 : -2)}, 2.4, particle_colour);
  };
  std::vector<Key> keys;
  if (!report.estimate.empty()) keys.push_back({"estimate", line(3, estimate_colour, 0)});
  if (report.truth) keys.push_back({"truth", line(7, truth_colour, 0)});
  if (!report.odometry.empty()) keys.push_back({"odometry alone", line(2.5, odometry_colour, 11)});
  if (!report.snapshots.empty()) keys.push_back({"particles", particles});
  if (report.estimate.empty()) return keys;
  keys.push_back({"start", [](Canvas& canvas, Pixel at) { draw_ring(canvas, {at.x + 19, at.y}); }});
  keys.push_back({"end", [](Canvas& canvas, Pixel at) { draw_square(canvas, {at.x + 19, at.y}); }});
  return keys;
}

/// The strip under the map, in as many lines as it takes; gives its height.
std::int32_t draw_legend(Canvas& canvas, const std::vector<Key>& keys, std::int32_t width, std::int32_t top) {
  constexpr double kSample_px = 48;
  if (keys.empty()) return 0;
  double x = margin_px;
  std::int32_t lines = 1;
  for (const Key& key : keys) {
    const double wide = kSample_px + canvas.text_width(key.label) + 2 * margin_px;
    if (x > margin_px && x + wide > width) x = margin_px, ++lines;
    const double middle = top + margin_px / 2 + (lines - 0.5) * line_px;
    key.draw(canvas, {x, middle});
    canvas.text({x + kSample_px, middle}, key.label, ink);
    x += wide;
  }
  return lines * line_px + margin_px;
}

void draw_robot(Canvas& canvas, const Pose& pose, const MapView& view) {
  if (!drawable_point(pose.x_m, pose.y_m) || !std::isfinite(pose.theta_rad)) return;
  const Pixel at = view.to_pixel(pose.x_m, pose.y_m);
  const double angle = view.to_image_angle(pose.theta_rad);
  canvas.disc(at, 7, white);
  canvas.line({at, {at.x + 16 * std::cos(angle), at.y - 16 * std::sin(angle)}}, 3, robot_colour);
  canvas.disc(at, 5.5, robot_colour);
}

}  // namespace

void write_map_picture(const std::string& path, const GridMap& map) {
  RunReport report;
  report.map = &map;
  const MapView view = view_to_write(path, report, least_px, most_px);
  Canvas canvas(view.width_px, view.height_px);
  draw_cells(canvas, map, view, map.walls.empty() ? ink : pale_walls);
  draw_walls(canvas, map, view);
  draw_scale_bar(canvas, view);
  replace_file(path, canvas.png());
}

void write_hypothesis_picture(const std::string& path, const GridMap& map,
                              const std::vector<Hypothesis>& hypotheses, const std::vector<EndPoint>& ends) {
  RunReport report;
  report.map = &map;
  const MapView view = view_to_write(path, report, least_px, most_px);
  Canvas canvas(view.width_px, view.height_px);
  draw_cells(canvas, map, view, ink);
  if (!hypotheses.empty()) draw_scan(canvas, view, hypotheses.front().pose, ends);
  for (std::size_t n = hypotheses.size(); n-- > 0;)  // the best on top
    draw_hypothesis(canvas, view, hypotheses[n], n + 1);
  draw_scale_bar(canvas, view);
  replace_file(path, canvas.png());
}

void write_picture(const std::string& path, const RunReport& report) {
  const MapView view = view_to_write(path, report, least_px, most_px);
  const std::vector<Key> keys = legend_keys(report);
  Canvas ruler(1, 1);  // how wide labels are, before there is a picture for them
  const std::int32_t legend_px = draw_legend(ruler, keys, view.width_px, 0);
  Canvas canvas(view.width_px, view.height_px + legend_px);
  canvas.clipped(0, 0, view.width_px, view.height_px, [&] {
    if (report.map != nullptr) draw_cells(canvas, *report.map, view, ink);
    draw_paths_and_clouds(canvas, report, view);
    draw_scale_bar(canvas, view);
  });
  draw_legend(canvas, keys, view.width_px, view.height_px);
  replace_file(path, canvas.png());
}

void write_live_picture(const std::string& path, const RunReport& report, const std::string& caption) {
  const MapView view = view_to_write(path, report, least_live_px, most_live_px);
  constexpr std::int32_t kStrip_px = line_px + margin_px / 2;
  Canvas canvas(view.width_px, view.height_px + kStrip_px);
  canvas.clipped(0, 0, view.width_px, view.height_px, [&] {
    if (report.map != nullptr) draw_cells(canvas, *report.map, view, ink);
    draw_track(canvas, report.estimate, view, 2, 0, estimate_colour);
    draw_clouds(canvas, report, view);
    if (!report.estimate.empty()) draw_robot(canvas, report.estimate.back().pose, view);
    draw_scale_bar(canvas, view);
  });
  canvas.text({margin_px, view.height_px + 0.5 * kStrip_px}, caption, ink);
  replace_file(path, canvas.png(PngEffort::fast));
}

void write_error_picture(const std::string& path, const RunReport& report) {
  std::vector<Plot> plots = error_plots(report);
  if (plots.empty()) throw Error(ErrorKind::output, path + ": cannot be written: no errors to show");
  plots.front().series.front().label = "estimate minus truth";
  constexpr std::int32_t kHeight_px = 180;
  replace_file(path, plot_picture(plots, time_axis(report.errors->stamp_s), kHeight_px));
}

}  // namespace parloc::tools
