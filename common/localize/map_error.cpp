#include "common/localize/map_error.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kFits_m = 0.3;  ///< A beam that ends so close to its wall is on it.
constexpr double kLeastLength_m = 0.3, kMostLength_m = 1.0;  ///< Of a piece of wall that has a direction.
constexpr double kLeastIncidence = 0.2;
constexpr std::size_t kFewest = 5;  ///< Pieces that say something.
/// Of the mean information: what keeps a direction finite that no wall holds.
constexpr double kUnheld = 0.02;

/// Standard deviations [cells]: of all walls and ranges together, of each wall by itself, and of what is
/// neither. Fitted on some families of drives and judged on others (docs/results/health.md).
constexpr double kAllFarther_cells = 0.5, kEachOff_cells = 0.1, kRest_cells = 0.1, kRest_rad = 0.001;

struct Point {
  double x, y;
};

/// Row of the distance to a wall by the pose [1, 1, m].
using Row = std::array<double, 3>;

/// The row of the wall that goes through the ends of beams `a` and `b`, seen from the origin of `a`.
std::optional<Row> row_of(const Point& a, const Point& middle, const Point& b, const Point& direction,
                          double length_m, double resolution_m) {
  double nx = (b.y - a.y) / length_m, ny = -(b.x - a.x) / length_m;
  double incidence = nx * direction.x + ny * direction.y;
  if (incidence < 0.0) nx = -nx, ny = -ny, incidence = -incidence;
  const double off_m = nx * (middle.x - a.x) + ny * (middle.y - a.y);
  if (incidence < kLeastIncidence || std::fabs(off_m) > resolution_m) return std::nullopt;
  return Row{nx, ny, ny * middle.x - nx * middle.y};
}

/// Of a symmetric positive definite matrix, by rows.
std::array<double, 9> inverse_of(const std::array<double, 9>& a) {
  const double c00 = a[4] * a[8] - a[5] * a[5], c01 = a[2] * a[5] - a[1] * a[8],
               c02 = a[1] * a[5] - a[2] * a[4];
  const double c11 = a[0] * a[8] - a[2] * a[2], c12 = a[1] * a[2] - a[0] * a[5],
               c22 = a[0] * a[4] - a[1] * a[1];
  const double per_det = 1.0 / (a[0] * c00 + a[1] * c01 + a[2] * c02);
  std::array<double, 9> out{c00, c01, c02, c01, c11, c12, c02, c12, c22};
  for (double& v : out) v *= per_det;
  return out;
}

}  // namespace

WallGeometry wall_geometry(const BeamTable& beams, const std::vector<float>& expected_m,
                           double resolution_m) {
  std::vector<Point> ends, directions;
  for (std::size_t m = 0; m < beams.hits; ++m) {
    const double range_m = static_cast<double>(expected_m[m]);
    if (std::fabs(range_m - static_cast<double>(beams.range_m[m])) > kFits_m) continue;
    const Point u{static_cast<double>(beams.direction_x[m]), static_cast<double>(beams.direction_y[m])};
    ends.push_back({static_cast<double>(beams.origin_x[m]) + range_m * u.x,
                    static_cast<double>(beams.origin_y[m]) + range_m * u.y});
    directions.push_back(u);
  }
  std::array<double, 9> information{};
  Row sum{};
  std::size_t rows = 0;
  for (std::size_t a = 0; a + 2 < ends.size(); ++a) {
    double length_m = 0.0;
    std::size_t b = a + 1;
    for (; b < ends.size(); ++b) {
      const double x = ends[b].x - ends[a].x, y = ends[b].y - ends[a].y;
      length_m = std::sqrt(x * x + y * y);
      if (length_m >= kLeastLength_m) break;
    }
    if (b == ends.size() || length_m > kMostLength_m) continue;
    const auto row = row_of(ends[a], ends[(a + b) / 2], ends[b], directions[a], length_m, resolution_m);
    if (!row) continue;
    ++rows;
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += (*row)[i];
      for (std::size_t j = 0; j < 3; ++j) information[3 * i + j] += (*row)[i] * (*row)[j];
    }
  }
  WallGeometry walls;
  if (rows < kFewest) return walls;
  const double per_row = 1.0 / static_cast<double>(rows);
  for (double& v : information) v *= per_row;
  const double lever2 = information[8] + 1e-4;
  information[0] += kUnheld;
  information[4] += kUnheld;
  information[8] += kUnheld * lever2 + 1e-4;
  walls.each_off = inverse_of(information);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) walls.all_farther[i] += walls.each_off[3 * i + j] * sum[j] * per_row;
  walls.known = true;
  return walls;
}

Covariance map_error(const WallGeometry& walls, double heading_rad, double resolution_m) {
  const double all_m = kAllFarther_cells * resolution_m, each_m = kEachOff_cells * resolution_m;
  const double rest_m = kRest_cells * resolution_m;
  std::array<double, 9> base{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3 && walls.known; ++j)
      base[3 * i + j] = all_m * all_m * walls.all_farther[i] * walls.all_farther[j] +
                        each_m * each_m * walls.each_off[3 * i + j];
  const SinCos64 r = portable_sincos64(heading_rad);
  const std::array<double, 9> turn{r.cos, -r.sin, 0.0, r.sin, r.cos, 0.0, 0.0, 0.0, 1.0};
  Covariance map;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l)
          map.v[3 * i + j] += turn[3 * i + k] * base[3 * k + l] * turn[3 * j + l];
  map.v[0] += rest_m * rest_m;
  map.v[4] += rest_m * rest_m;
  map.v[8] += kRest_rad * kRest_rad;
  return map;
}

void add_map_error(const WallGeometry& walls, double heading_rad, double resolution_m,
                   Covariance& covariance) {
  const Covariance map = map_error(walls, heading_rad, resolution_m);
  for (std::size_t i = 0; i < 9; ++i) covariance.v[i] += map.v[i];
}

}  // namespace parloc
