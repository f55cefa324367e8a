#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/math/quantile.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/png_writer.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr std::int32_t most_map_px = 1600;
constexpr std::size_t most_scan_points = 1000;

std::string scan_points(const Snapshot& snapshot, const MapView& view, const std::string& id) {
  std::string d;
  for (const std::size_t k : evenly_spaced(snapshot.scan_points.size(), most_scan_points)) {
    const Snapshot::Point& p = snapshot.scan_points[k];
    if (!drawable_point(p.x_m, p.y_m)) continue;
    const Pixel at = view.to_pixel(p.x_m, p.y_m);
    fmt::format_to(std::back_inserter(d), "M{:.1f} {:.1f}h0", at.x, at.y);
  }
  return d.empty() ? "" : fmt::format("<path id=\"{}\" class=\"scan c5\" d=\"{}\"/>", id, d);
}

std::string start_and_end(const Trajectory& track, const MapView& view) {
  if (track.empty()) return "";
  return dot("spot c1", track.front().pose, view) + dot("hole", track.front().pose, view) +
         dot("end c1", track.back().pose, view);
}

std::string moment_layer(const Snapshot& snapshot, const MapView& view, const Axis& axis, std::size_t index,
                         bool shown) {
  const double arrow_px = 0.035 * std::max(view.width_px, view.height_px);
  return moment_group("snap", snapshot.stamp_s, axis, shown) +
         scan_points(snapshot, view, fmt::format("scan{}", index)) +
         cloud(snapshot, view, fmt::format("cloud{}", index)) + arrow(snapshot.pose, view, arrow_px) + "</g>";
}

std::string map_legend(const RunReport& report) {
  const bool scans = std::any_of(report.snapshots.begin(), report.snapshots.end(),
                                 [](const Snapshot& s) { return !s.scan_points.empty(); });
  std::string html = "<figcaption><b>Map and paths</b>";
  if (!report.estimate.empty()) html += legend_key("line c1", "estimate");
  if (report.truth) html += legend_key("wide c2", "truth");
  if (!report.odometry.empty()) html += legend_key("dash c3", "odometry alone");
  if (!report.snapshots.empty()) html += legend_key("dot c4", "particles");
  if (scans) html += legend_key("dot c5", "scan");
  if (!report.estimate.empty()) html += legend_key("ring c1", "start") + legend_key("box c1", "end");
  return html + "</figcaption>";
}

/// The clouds of all moments, behind that of the chosen one.
std::string trail(std::size_t moments) {
  std::string html = "<g class=\"trail\">";
  for (std::size_t k = 0; k < moments; ++k) html += fmt::format("<use href=\"#cloud{}\"/>", k);
  return html + "</g>";
}

std::string overview(const RunReport& report, const MapView& view, const Axis& axis,
                     const std::vector<std::size_t>& moments) {
  std::string html;
  if (report.map != nullptr) html += map_image(*report.map, view);
  constexpr PathDetail paths{20000, 0.33};
  if (report.truth) html += svg_path("truth c2", track_path(*report.truth, view, paths));
  if (report.every_cloud) html += trail(moments.size());
  html += svg_path("estimate c1", track_path(report.estimate, view, paths));
  html += svg_path("odometry c3", track_path(report.odometry, view, paths)) +
          start_and_end(report.estimate, view);
  for (std::size_t k = 0; k < moments.size(); ++k) {
    html += moment_layer(report.snapshots[moments[k]], view, axis, k, k + 1 == moments.size());
  }
  return "<figure>" + map_legend(report) + map_frame(view, "Map and paths", html) + "</figure>\n";
}

/// Half the side of a square around the estimate that holds nearly all particles [m].
double closeup_half_side_m(const Snapshot& snapshot, const MapView& view) {
  std::vector<double> distances;
  for (const Particle& p : snapshot.particles) {
    const double distance = std::hypot(p.x_m - snapshot.pose.x_m, p.y_m - snapshot.pose.y_m);
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  const double half = distances.empty() ? 0.0 : nearest_rank(ascending(std::move(distances)), 98);
  return std::min(std::max(1.5 * half, 0.05), 0.5 * std::max(view.width_px, view.height_px) * view.pixel_m());
}

std::string closeup(const RunReport& report, const Snapshot& snapshot, const MapView& view, const Axis& axis,
                    std::size_t index) {
  const std::string when = time_text(axis, snapshot.stamp_s);
  if (!drawable_point(snapshot.pose.x_m, snapshot.pose.y_m)) {
    return fmt::format("<figure><figcaption>{}; no pose</figcaption></figure>",
                       when);  // the script counts figures
  }
  const double half_m = closeup_half_side_m(snapshot, view);
  const double half_px = half_m / view.pixel_m();
  const Pixel centre = view.to_pixel(snapshot.pose.x_m, snapshot.pose.y_m);
  std::string html = fmt::format(
      "<figure><svg viewBox=\"{:.2f} {:.2f} {:.2f} {:.2f}\" role=\"img\" aria-label=\"Particles at {}\">",
      centre.x - half_px, centre.y - half_px, 2 * half_px, 2 * half_px, when);
  if (report.map != nullptr) html += "<use href=\"#cells\"/>";
  if (!snapshot.scan_points.empty()) html += fmt::format("<use href=\"#scan{}\"/>", index);
  html += fmt::format("<use class=\"dots\" href=\"#cloud{}\"/>", index);
  const StampedPose* truth = report.truth ? nearest_pose(*report.truth, snapshot.stamp_s) : nullptr;
  if (truth != nullptr) html += dot("spot c2", truth->pose, view) + dot("hole", truth->pose, view);
  html += arrow(snapshot.pose, view, 0.45 * half_px) + "</svg>";
  return html +
         fmt::format("<figcaption>{}; {} m wide</figcaption></figure>", when, number_text(2 * half_m, 2));
}

}  // namespace

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

std::string moment_group(const char* kind, double stamp_s, const Axis& axis, bool shown) {
  const double at = drawable(stamp_s) ? std::clamp(100 * axis.fraction(stamp_s), 0.0, 100.0) : 0.0;
  return fmt::format("<g class=\"{}\" data-time=\"{}\" data-at=\"{:.2f}\"{}>", kind, time_text(axis, stamp_s),
                     at, shown ? "" : " style=\"display:none\"");
}

std::string time_text(const Axis& axis, double stamp_s) {
  return drawable(stamp_s)
             ? number_text((stamp_s - axis.zero) / axis.unit, axis.unit > 1 ? 2 : 1) + " " + axis.name
             : "unknown time";
}

std::string map_data_uri(const GridMap& map, const MapView& view) {
  std::vector<std::uint8_t> pixels;
  for (const Cell cell : raster(map, view)) pixels.push_back(static_cast<std::uint8_t>(cell));
  const std::vector<Rgba> palette = {
      {255, 255, 255, 0}, {25, 28, 32, 255}, {128, 128, 128, 64}};  // as enum Cell
  return png_data_uri(encode_png_palette(view.width_px, view.height_px, pixels, palette));
}

std::string map_image(const GridMap& map, const MapView& view) {
  return fmt::format("<image id=\"cells\" class=\"cells\" width=\"{}\" height=\"{}\" href=\"{}\"/>",
                     view.width_px, view.height_px, map_data_uri(map, view));
}

std::string map_frame(const MapView& view, const char* label, const std::string& drawing, double most_vh) {
  const double length_m = scale_bar_m(view);
  return fmt::format(
      "<div class=\"map\" style=\"max-width:{:.1f}vh\"><svg viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"{}\">{}</svg><div class=\"scale\" style=\"width:{:.3f}%\">{} m</div></div>",
      most_vh * view.width_px / view.height_px, view.width_px, view.height_px, label, drawing,
      100 * length_m / (view.width_px * view.pixel_m()), number_text(length_m, 4));
}

std::string legend_key(const std::string& mark, const std::string& label) {
  return fmt::format("<span class=\"key\"><i class=\"{}\"></i>{}</span>", mark, label);
}

const char* invert_filter() {
  return "<svg width=\"0\" height=\"0\" style=\"position:absolute\" aria-hidden=\"true\"><filter "
         "id=\"invert\" "
         "color-interpolation-filters=\"sRGB\"><feComponentTransfer><feFuncR type=\"linear\" slope=\"-1\" "
         "intercept=\"1\"/><feFuncG type=\"linear\" slope=\"-1\" intercept=\"1\"/><feFuncB type=\"linear\" "
         "slope=\"-1\" intercept=\"1\"/></feComponentTransfer></filter></svg>";
}

std::string map_figures(const RunReport& report, const Axis& axis) {
  const std::optional<MapView> fitted = fit_view(report, 1, most_map_px);
  if (!fitted) return "";
  const MapView& view = *fitted;
  const std::vector<std::size_t> moments = evenly_spaced(report.snapshots.size(), kMostMoments);
  std::string html = invert_filter() + growth_figures(report, view, axis) + "<h2>Where it was</h2>\n" +
                     overview(report, view, axis, moments);
  if (moments.empty()) return html;
  html += fmt::format(
      "<div class=\"moment\"><label for=\"moment\">Particles at</label><input type=\"range\" "
      "id=\"moment\" min=\"0\" max=\"{}\" value=\"{}\"/><output id=\"when\">{}</output></div>\n",
      moments.size() - 1, moments.size() - 1, time_text(axis, report.snapshots[moments.back()].stamp_s));
  html += "<p class=\"note\">Close-ups of the particles, each around its estimate (arrow)";
  html += report.truth ? "; the ring is the truth.</p>\n" : ".</p>\n";
  html += "<div class=\"closeups\">";
  for (std::size_t k = 0; k < moments.size(); ++k) {
    html += closeup(report, report.snapshots[moments[k]], view, axis, k);
  }
  return html + "</div>\n";
}

}  // namespace parloc::tools
