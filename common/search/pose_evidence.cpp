#include "common/search/pose_evidence.h"

#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

/// A measured range is that of the map's wall if it differs by at most this, plus a share of itself: the
/// map's cells, the pose's last centimetres and degree.
constexpr float kTolerance_m = 0.15f, kToleranceShare = 0.02f;

/// A beam that meets a wall at a small angle ends at some other place of it; worth this much, its end is on a
/// wall.
constexpr double kOnWall = 0.5 * kMostValue;

/// Floor of a number of few digits, without a call.
std::int32_t cell_of(double x) {
  const auto cut = static_cast<std::int32_t>(x);
  return x < cut ? cut - 1 : cut;
}

/// Between four cell centres; u and v in cells.
double bilinear(const SearchGrid& grid, double u, double v) {
  if (!(u - 0.5 >= -1.0 && v - 0.5 >= -1.0 && u - 0.5 < grid.width && v - 0.5 < grid.height)) return 0.0;
  const std::int32_t i = cell_of(u - 0.5), j = cell_of(v - 0.5);
  const double a = u - 0.5 - i, b = v - 0.5 - j;
  const std::uint8_t* low = grid.cells.first + std::int64_t{j} * grid.cells.stride + i;  // zeros all around
  const std::uint8_t* high = low + grid.cells.stride;
  const double at_low = low[0] + a * (low[1] - low[0]);
  const double at_high = high[0] + a * (high[1] - high[0]);
  return at_low + b * (at_high - at_low);
}

}  // namespace

PoseEvidence::PoseEvidence(const GridMap& map, const SearchMap& search)
    : search_(search), grid_(search.view()), evidence_(map), resolution_m_(map.resolution_m) {}

double PoseEvidence::score(const BeamTable& beams, const Pose& pose) const {
  const SinCos64 r = portable_sincos64(pose.theta_rad);
  const double per_cell = 1.0 / search_.cell_m, scale = resolution_m_ * per_cell;
  double sum = 0.0;
  for (std::size_t m = 0; m < beams.hits; ++m) {
    const double x = beams.end_x[m] * scale, y = beams.end_y[m] * scale;
    sum += bilinear(grid_, pose.x_m * per_cell + r.cos * x - r.sin * y,
                    pose.y_m * per_cell + r.sin * x + r.cos * y);
  }
  return beams.hits > 0 ? sum / (static_cast<double>(kMostValue) * static_cast<double>(beams.hits)) : 0.0;
}

bool PoseEvidence::is_free(const Pose& pose) const {
  const double i = std::floor(pose.x_m / search_.cell_m), j = std::floor(pose.y_m / search_.cell_m);
  if (!(i >= 0.0 && j >= 0.0 && i < grid_.width && j < grid_.height)) return false;
  return grid_.is_free(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
}

double PoseEvidence::refine(const BeamTable& beams, double heading_step_rad, Pose& pose,
                            std::int64_t& tried) const {
  double best = score(beams, pose);
  ++tried;
  double step_m = 0.5 * search_.cell_m, step_rad = 0.5 * heading_step_rad;
  for (int halvings = 0; halvings < 4; ++halvings, step_m *= 0.5, step_rad *= 0.5) {
    for (int round = 0; round < 4; ++round) {
      Pose moved = pose;
      for (int direction = 0; direction < 6; ++direction) {
        Pose other = pose;
        const double sign = direction % 2 == 0 ? 1.0 : -1.0;
        if (direction / 2 == 0) other.x_m += sign * step_m;
        if (direction / 2 == 1) other.y_m += sign * step_m;
        if (direction / 2 == 2) other.theta_rad = wrap64(other.theta_rad + sign * step_rad);
        if (!is_free(other)) continue;
        ++tried;
        const double s = score(beams, other);
        if (s > best) best = s, moved = other;
      }
      if (moved.x_m == pose.x_m && moved.y_m == pose.y_m && moved.theta_rad == pose.theta_rad) break;
      pose = moved;
    }
  }
  return best;
}

PoseVerdict PoseEvidence::judge(const BeamTable& beams, const Pose& pose) {
  const double evidence = evidence_.per_beam(beams, pose);
  const SinCos64 r = portable_sincos64(pose.theta_rad);
  const double per_cell = 1.0 / search_.cell_m, scale = resolution_m_ * per_cell;
  std::size_t explained = 0, through = 0, unmapped = 0;
  for (std::size_t m = 0; m < beams.count; ++m) {
    const float expected_m = evidence_.expected_m()[m], measured_m = beams.range_m[m];
    const float tolerance_m = kTolerance_m + kToleranceShare * measured_m;
    if (expected_m < measured_m - tolerance_m) {
      ++through;
    } else if (expected_m <= measured_m + tolerance_m) {
      ++explained;
    } else {
      const double ex = beams.end_x[m] * scale, ey = beams.end_y[m] * scale;
      const double value = bilinear(grid_, pose.x_m * per_cell + r.cos * ex - r.sin * ey,
                                    pose.y_m * per_cell + r.sin * ex + r.cos * ey);
      ++(value >= kOnWall ? explained : unmapped);
    }
  }
  const double count = beams.count > 0 ? static_cast<double>(beams.count) : 1.0;
  return {static_cast<double>(explained) / count, static_cast<double>(through) / count,
          static_cast<double>(unmapped) / count, evidence};
}

}  // namespace parloc
