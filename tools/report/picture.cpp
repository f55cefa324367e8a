#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/map_drawing.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/canvas.h"
#include "tools/report/pictures/picture_style.h"
#include "tools/report/pictures/png_writer.h"
#include "tools/report/report.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t least_px = 1100, most_px = 2000;
constexpr std::int32_t least_live_px = 600, most_live_px = 1000;

/// The dashes of a line that has come `travelled` pixels so far, cut where dash and gap meet. A segment of
/// more than `kLongest` dashes is drawn solid: it is a jump far outside the picture, and must not cost its
/// length.
void draw_dashes(Canvas& canvas, Pixel from, Pixel to, double travelled, double width_px, double dash_px,
                 Rgba colour) {
  constexpr double kLongest = 10'000;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (length > kLongest * dash_px) return canvas.line(from.x, from.y, to.x, to.y, width_px, colour);
  for (double at = 0.0; at < length;) {
    const double into = std::fmod(travelled + at, 2 * dash_px);
    const bool gap = into >= dash_px;
    const double end = std::min(length, at + std::max(1e-3, (gap ? 2 * dash_px : dash_px) - into));
    const double a = at / length, b = end / length;
    if (!gap)
      canvas.line(from.x + a * (to.x - from.x), from.y + a * (to.y - from.y), from.x + b * (to.x - from.x),
                  from.y + b * (to.y - from.y), width_px, colour);
    at = end;
  }
}

/// A solid line, or dashes of `dash_px` with gaps as long (0: solid).
void draw_track(Canvas& canvas, const Trajectory& track, const MapView& view, double width_px, double dash_px,
                Rgba colour) {
  bool pen_down = false;
  Pixel last;
  double travelled = 0.0;
  for (const StampedPose& p : track) {
    if (!drawable_point(p.pose.x_m, p.pose.y_m)) {
      pen_down = false;
      continue;
    }
    const Pixel to = view.to_pixel(p.pose.x_m, p.pose.y_m);
    const double step = pen_down ? std::hypot(to.x - last.x, to.y - last.y) : 0.0;
    if (pen_down && step < 0.7) continue;  // also bounds the work for a robot that stands still
    if (pen_down && dash_px > 0.0) draw_dashes(canvas, last, to, travelled, width_px, dash_px, colour);
    if (pen_down && dash_px <= 0.0) canvas.line(last.x, last.y, to.x, to.y, width_px, colour);
    travelled += step, last = to, pen_down = true;
  }
}

void draw_particles(Canvas& canvas, const Snapshot& snapshot, const MapView& view) {
  const std::vector<Particle>& particles = snapshot.particles;
  for (const std::size_t k : evenly_spaced(particles.size(), Snapshot::max_particles)) {
    if (!drawable_point(particles[k].x_m, particles[k].y_m)) continue;
    const Pixel at = view.to_pixel(particles[k].x_m, particles[k].y_m);
    canvas.disc(at.x, at.y, 1.6, particle_colour);
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

void draw_ring(Canvas& canvas, double x, double y) {
  canvas.disc(x, y, 8, estimate_colour);
  canvas.disc(x, y, 4.5, white);
}

void draw_square(Canvas& canvas, double x, double y) {
  canvas.rectangle(x - 8, y - 8, x + 8, y + 8, white);
  canvas.rectangle(x - 6.5, y - 6.5, x + 6.5, y + 6.5, estimate_colour);
}

void draw_start_and_end(Canvas& canvas, const Trajectory& track, const MapView& view) {
  if (track.empty()) return;
  const Pose &first = track.front().pose, &last = track.back().pose;
  if (drawable_point(first.x_m, first.y_m)) {
    const Pixel at = view.to_pixel(first.x_m, first.y_m);
    draw_ring(canvas, at.x, at.y);
  }
  if (drawable_point(last.x_m, last.y_m)) {
    const Pixel at = view.to_pixel(last.x_m, last.y_m);
    draw_square(canvas, at.x, at.y);
  }
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

enum class Key { truth, estimate, odometry, particles, start, end };

std::vector<Key> legend_keys(const RunReport& report) {
  std::vector<Key> keys;
  if (!report.estimate.empty()) keys.push_back(Key::estimate);
  if (report.truth) keys.push_back(Key::truth);
  if (!report.odometry.empty()) keys.push_back(Key::odometry);
  if (!report.snapshots.empty()) keys.push_back(Key::particles);
  if (!report.estimate.empty()) keys.insert(keys.end(), {Key::start, Key::end});
  return keys;
}

const char* key_label(Key key) {
  switch (key) {
    case Key::truth:
      return "truth";
    case Key::estimate:
      return "estimate";
    case Key::odometry:
      return "odometry alone";
    case Key::particles:
      return "particles";
    case Key::start:
      return "start";
    case Key::end:
      return "end";
  }
  return "";
}

void draw_key(Canvas& canvas, Key key, double x, double y) {
  switch (key) {
    case Key::truth:
      return canvas.line(x + 4, y, x + 34, y, 7, truth_colour);
    case Key::estimate:
      return canvas.line(x + 3, y, x + 35, y, 3, estimate_colour);
    case Key::odometry:
      canvas.line(x + 2, y, x + 13, y, 2.5, odometry_colour);
      return canvas.line(x + 24, y, x + 35, y, 2.5, odometry_colour);
    case Key::particles:
      for (int k = 0; k < 5; ++k) canvas.disc(x + 5 + 7 * k, y + (k % 2 == 0 ? 2 : -2), 2.4, particle_colour);
      return;
    case Key::start:
      return draw_ring(canvas, x + 19, y);
    case Key::end:
      return draw_square(canvas, x + 19, y);
  }
}

constexpr std::int32_t key_px = 48;  // room for the sample before its label

/// The strip under the map: what the marks mean, in as many lines as it takes.
struct Strip {
  struct Item {
    Key key;
    std::int32_t x, line;
  };
  std::vector<Item> items;
  std::int32_t lines = 1;
};

Strip legend_strip(const RunReport& report, std::int32_t width) {
  Strip strip;
  std::int32_t x = margin_px;
  for (const Key key : legend_keys(report)) {
    const std::int32_t wide = key_px + Canvas::text_width(key_label(key), text_scale) + 2 * margin_px;
    if (x > margin_px && x + wide > width) x = margin_px, ++strip.lines;
    strip.items.push_back({key, x, strip.lines - 1});
    x += wide;
  }
  return strip;
}

void draw_strip(Canvas& canvas, const Strip& strip, std::int32_t top) {
  for (const Strip::Item& item : strip.items) {
    const std::int32_t middle = top + margin_px / 2 + item.line * line_px + line_px / 2;
    draw_key(canvas, item.key, item.x, middle);
    canvas.text(item.x + key_px, middle - 7 * text_scale / 2, key_label(item.key), text_scale, ink);
  }
}

void draw_robot(Canvas& canvas, const Pose& pose, const MapView& view) {
  if (!drawable_point(pose.x_m, pose.y_m) || !std::isfinite(pose.theta_rad)) return;
  const Pixel at = view.to_pixel(pose.x_m, pose.y_m);
  const double angle = view.to_image_angle(pose.theta_rad);
  canvas.disc(at.x, at.y, 7, white);
  canvas.line(at.x, at.y, at.x + 16 * std::cos(angle), at.y - 16 * std::sin(angle), 3, robot_colour);
  canvas.disc(at.x, at.y, 5.5, robot_colour);
}

MapView view_of(const std::string& path, const RunReport& report, std::int32_t least, std::int32_t most) {
  const std::optional<MapView> view = fit_view(report, least, most);
  if (!view) throw Error(ErrorKind::output, path + ": cannot be written: neither a map nor a path to show");
  return *view;
}

/// One above the other; both of the same width.
std::string encode_stacked(const Canvas& upper, const Canvas& lower, PngEffort effort) {
  std::vector<std::uint8_t> pixels = upper.pixels();
  pixels.insert(pixels.end(), lower.pixels().begin(), lower.pixels().end());
  return encode_png_rgb(upper.width(), upper.height() + lower.height(), pixels, effort);
}

}  // namespace

void write_picture(const std::string& path, const RunReport& report) {
  const MapView view = view_of(path, report, least_px, most_px);
  const Strip strip = legend_strip(report, view.width_px);
  const std::int32_t strip_px = strip.items.empty() ? 0 : strip.lines * line_px + margin_px;
  Canvas map(view.width_px, view.height_px, white);
  if (report.map != nullptr) draw_cells(map, *report.map, view, ink);
  draw_paths_and_clouds(map, report, view);
  draw_scale_bar(map, view);

  Canvas legend(view.width_px, strip_px, white);
  draw_strip(legend, strip, 0);
  replace_file(path, encode_stacked(map, legend, PngEffort::small));
}

void write_live_picture(const std::string& path, const RunReport& report, const std::string& caption) {
  const MapView view = view_of(path, report, least_live_px, most_live_px);
  Canvas map(view.width_px, view.height_px, white);
  if (report.map != nullptr) draw_cells(map, *report.map, view, ink);
  draw_track(map, report.estimate, view, 2, 0, estimate_colour);
  draw_clouds(map, report, view);
  if (!report.estimate.empty()) draw_robot(map, report.estimate.back().pose, view);
  draw_scale_bar(map, view);
  Canvas strip(view.width_px, line_px + margin_px / 2, white);
  strip.text(margin_px, (strip.height() - 7 * text_scale) / 2, caption, text_scale, ink);
  replace_file(path, encode_stacked(map, strip, PngEffort::fast));
}

}  // namespace parloc::tools
