#include "tools/report/report_marks.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

std::string track_path(const Trajectory& track, const MapView& view, const PathDetail& detail) {
  std::string d;
  auto out = std::back_inserter(d);
  bool pen_down = false;
  Pixel last;
  const std::vector<std::size_t> kept = evenly_spaced(track.size(), detail.most_points);
  for (const std::size_t k : kept) {
    const Pose& pose = track[k].pose;
    if (!drawable_point(pose.x_m, pose.y_m)) {
      pen_down = false;
      continue;
    }
    const Pixel p = view.to_pixel(pose.x_m, pose.y_m);
    if (pen_down && k != kept.back() && std::hypot(p.x - last.x, p.y - last.y) < detail.least_px) continue;
    fmt::format_to(out, "{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', p.x, p.y);
    pen_down = true, last = p;
  }
  return d;
}

std::string svg_path(const std::string& classes, const std::string& d) {
  return d.empty() ? "" : fmt::format("<path class=\"{}\" d=\"{}\"/>", classes, d);
}

std::string cloud(const Snapshot& snapshot, const MapView& view, const std::string& id) {
  float heaviest = 0.0F;
  for (const Particle& p : snapshot.particles) heaviest = p.weight > heaviest ? p.weight : heaviest;
  std::string faint, half, full;
  for (const std::size_t k : evenly_spaced(snapshot.particles.size(), Snapshot::max_particles)) {
    const Particle& p = snapshot.particles[k];
    if (!drawable_point(p.x_m, p.y_m)) continue;
    const Pixel at = view.to_pixel(p.x_m, p.y_m);
    std::string& d = p.weight >= 0.3F * heaviest ? full : p.weight >= 0.03F * heaviest ? half : faint;
    fmt::format_to(std::back_inserter(d), "M{:.2f} {:.2f}h0", at.x, at.y);
  }
  return fmt::format("<g id=\"{}\">{}{}{}</g>", id, svg_path("cloud faint c4", faint),
                     svg_path("cloud half c4", half), svg_path("cloud c4", full));
}

std::string arrow(const Pose& pose, const MapView& view, double length_px) {
  if (!drawable_point(pose.x_m, pose.y_m) || !std::isfinite(pose.theta_rad)) return "";
  const Pixel from = view.to_pixel(pose.x_m, pose.y_m);
  const double angle = view.to_image_angle(pose.theta_rad);
  const auto along = [&](double at, double turn) {
    return Pixel{from.x + length_px * at * std::cos(angle + turn),
                 from.y - length_px * at * std::sin(angle + turn)};
  };
  const Pixel tip = along(1.0, 0.0), left = along(0.7, 0.25), right = along(0.7, -0.25);
  return svg_path(
      "arrow", fmt::format("M{:.2f} {:.2f}L{:.2f} {:.2f}M{:.2f} {:.2f}L{:.2f} {:.2f}L{:.2f} {:.2f}", from.x,
                           from.y, tip.x, tip.y, left.x, left.y, tip.x, tip.y, right.x, right.y));
}

std::string dot(const std::string& classes, const Pose& pose, const MapView& view) {
  if (!drawable_point(pose.x_m, pose.y_m)) return "";
  const Pixel at = view.to_pixel(pose.x_m, pose.y_m);
  return svg_path(classes, fmt::format("M{:.2f} {:.2f}h0", at.x, at.y));
}

std::string time_text(const Axis& axis, double stamp_s) {
  return drawable(stamp_s)
             ? number_text((stamp_s - axis.zero) / axis.unit, axis.unit > 1 ? 2 : 1) + " " + axis.name
             : "unknown time";
}

}  // namespace parloc::tools
