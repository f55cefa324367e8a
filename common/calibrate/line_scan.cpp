#include "common/calibrate/line_scan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "common/math/portable64.h"

namespace parloc {
namespace {

/// Ends this near one another are on one wall, or farther apart by as many beams' spacing: so far aslant a
/// wall may be seen.
constexpr double kNear_m = 0.1, kNearSpacings = 5.0;
/// A piece of wall reaches so far to either side of its middle: longer ones have a surer normal, shorter ones
/// lie on curved walls, too.
constexpr double kReach_m = 0.15;
constexpr std::size_t kMostNeighbours = 16;  // to a side
/// Ends that are farther than this from their line (root mean square), or a third of their spread along it,
/// are on none.
constexpr double kStraight_m = 0.03, kStraightShare = 0.33;

struct End {
  double x_m, y_m, range_m, bearing_rad;
};

std::vector<End> ends_of(const Scan& scan, LidarSetup setup,
                         const std::function<Pose(double time_s)>& moved) {
  const LidarSetup mounted = setup;
  setup.upside_down = false;
  std::vector<End> ends;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = static_cast<double>(scan.ranges_m[i]);
    if (!(range_m > 0.0 && range_m >= setup.range_min_m && range_m < setup.range_max_m)) continue;
    if (is_masked(scan, mounted, i)) continue;
    const SinCos64 direction = portable_sincos64(beam_bearing_rad(scan, setup, i));
    Pose end{range_m * direction.cos, range_m * direction.sin, 0.0};
    if (moved) end = compose(moved(beam_time_s(scan, setup, i)), end);
    ends.push_back({end.x_m, end.y_m, range_m, portable_atan2_64(end.y_m, end.x_m)});
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.bearing_rad < b.bearing_rad; });
  return ends;
}

/// The ends of a scan go round; whether two in a row are on one wall.
class Ring {
 public:
  explicit Ring(const std::vector<End>& ends, double step_rad) : ends_(ends), step_rad_(step_rad) {}
  const End& at(std::ptrdiff_t k) const {
    const auto n = static_cast<std::ptrdiff_t>(ends_.size());
    return ends_[static_cast<std::size_t>(((k % n) + n) % n)];
  }
  bool joined(std::ptrdiff_t k) const {
    const End &a = at(k), &b = at(k + 1);
    const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
    const double near_m = std::max(kNear_m, kNearSpacings * step_rad_ * std::min(a.range_m, b.range_m));
    return dx * dx + dy * dy < near_m * near_m;
  }

 private:
  const std::vector<End>& ends_;
  double step_rad_;
};

/// First and last neighbour on the same wall.
void reach_of(const Ring& ring, std::ptrdiff_t middle, std::ptrdiff_t& first, std::ptrdiff_t& last) {
  const End& m = ring.at(middle);
  const auto goes_on = [&](std::ptrdiff_t k, std::ptrdiff_t taken) {
    const double dx = ring.at(k).x_m - m.x_m, dy = ring.at(k).y_m - m.y_m;
    return taken < 2 ||
           (taken < static_cast<std::ptrdiff_t>(kMostNeighbours) && dx * dx + dy * dy < kReach_m * kReach_m);
  };
  first = last = middle;
  while (ring.joined(first - 1) && goes_on(first - 1, middle - first)) --first;
  while (ring.joined(last) && goes_on(last + 1, last - middle)) ++last;
}

bool fit_piece(const Ring& ring, std::ptrdiff_t middle, WallPiece& piece) {
  std::ptrdiff_t first = 0, last = 0;
  reach_of(ring, middle, first, last);
  if (first == middle || last == middle || last - first < 3) return false;
  const double n = static_cast<double>(last - first + 1);
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (std::ptrdiff_t k = first; k <= last; ++k) x += ring.at(k).x_m, y += ring.at(k).y_m;
  x /= n, y /= n;
  for (std::ptrdiff_t k = first; k <= last; ++k) {
    const double dx = ring.at(k).x_m - x, dy = ring.at(k).y_m - y;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  const double middle_of = 0.5 * (xx + yy);
  const double half = std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  const double across = std::max(middle_of - half, 0.0) / n, along = (middle_of + half) / n;
  if (across > kStraight_m * kStraight_m || across > kStraightShare * kStraightShare * along) return false;
  // The eigenvector of the smaller eigenvalue, from the longer of the two rows that it is normal to.
  const double least = middle_of - half;
  double nx = xy, ny = least - xx;
  if (std::fabs(yy - least) > std::fabs(xx - least)) nx = least - yy, ny = xy;
  const double length = std::sqrt(nx * nx + ny * ny);
  if (!(length > 0.0)) return false;
  constexpr double kLeastAcross_m2 = 1e-4;  // of few ends it may be nearly nothing by chance
  piece = {x, y, nx / length, ny / length, std::max(across, kLeastAcross_m2) / (n * along)};
  return true;
}

/// Middles are unlike their scan's ends in bearing order at corners.
void sort_pieces(LineScan& scan) {
  std::stable_sort(scan.pieces.begin(), scan.pieces.end(), [](const WallPiece& a, const WallPiece& b) {
    return portable_atan2_64(a.y_m, a.x_m) < portable_atan2_64(b.y_m, b.x_m);
  });
  for (const WallPiece& p : scan.pieces) scan.bearings_rad.push_back(portable_atan2_64(p.y_m, p.x_m));
}

}  // namespace

LineScan line_scan(const Scan& scan, const LidarSetup& setup,
                   const std::function<Pose(double time_s)>& moved) {
  LineScan lines;
  const std::vector<End> ends = ends_of(scan, setup, moved);
  if (ends.size() < 4) return lines;
  double step_rad = std::fabs(setup.angle_step_rad);
  if (setup.own_bearings && scan.bearings_rad.size() > 1)
    step_rad = std::fabs(scan.bearings_rad.back() - scan.bearings_rad.front()) /
               static_cast<double>(scan.bearings_rad.size() - 1);
  const Ring ring(ends, step_rad);
  const std::size_t every = (ends.size() + LineScan::kMostPieces - 1) / LineScan::kMostPieces;
  WallPiece piece{};
  for (std::size_t k = 0; k < ends.size(); k += every)
    if (fit_piece(ring, static_cast<std::ptrdiff_t>(k), piece)) lines.pieces.push_back(piece);
  sort_pieces(lines);
  return lines;
}

}  // namespace parloc
