#include "common/simulator/wander.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <queue>
#include <utility>

#include "common/error.h"
#include "common/map/grid_map.h"
#include "common/map/rays/skip_field.h"
#include "common/math/philox.h"
#include "common/simulator/drive.h"

namespace parloc {
namespace {

constexpr double kStride_m = 0.2;
constexpr double kNearestGoal_m = 3.0, kFarthestGoal_m = 20.0;
constexpr std::size_t kMostPoints = 100000;

/// Length of a step between nodes: 5 straight, 7 across. Integers, so that no rounding decides a way.
std::int32_t step_length(std::int32_t di, std::int32_t dj) {
  return di != 0 && dj != 0 ? 7 : 5;
}

}  // namespace

WanderArea::WanderArea(const GridMap& map, double clearance_m)
    : width_(map.width),
      height_(map.height),
      resolution_m_(map.resolution_m),
      T_map_grid_(map.T_map_grid),
      stride_(std::max(1, static_cast<std::int32_t>(std::lround(kStride_m / map.resolution_m)))),
      columns_((map.width + stride_ - 1) / stride_),
      rows_((map.height + stride_ - 1) / stride_) {
  // The Chebyshev distance to the nearest cell that is not free, at most 255 cells.
  const SkipField distance = skip_field(blocking_cells(map, true).data(), width_, height_, 0);
  const double least = std::min(clearance_m / resolution_m_ + 0.5, 255.0);
  clear_.resize(map.size());
  for (std::int32_t j = 0; j < height_; ++j)
    for (std::int32_t i = 0; i < width_; ++i)
      clear_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i)] =
          distance.lines[static_cast<std::size_t>(j + 1) * static_cast<std::size_t>(width_ + 2) +
                         static_cast<std::size_t>(i + 1)] >= least
              ? 1
              : 0;
  open_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::int32_t r = 0; r < rows_; ++r)
    for (std::int32_t c = 0; c < columns_; ++c)
      open_[static_cast<std::size_t>(r * columns_ + c)] = clear(c * stride_, r * stride_) ? 1 : 0;
  keep_largest_region();
  if (places_.size() < 2)
    throw Error(ErrorKind::input, fmt::format("{}: no free region that a robot can cross {} m clear of walls",
                                              map.name, clearance_m));
}

double WanderArea::area_m2() const {
  const double side_m = stride_ * resolution_m_;
  return static_cast<double>(places_.size()) * side_m * side_m;
}

bool WanderArea::clear(std::int32_t i, std::int32_t j) const {
  return i >= 0 && j >= 0 && i < width_ && j < height_ &&
         clear_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) +
                static_cast<std::size_t>(i)] != 0;
}

/// Whether the straight way between two nodes is clear, looked at in steps of less than a cell.
bool WanderArea::clear_way(Node from, Node to) const {
  const std::int32_t i = from % columns_ * stride_, j = from / columns_ * stride_;
  const std::int32_t di = to % columns_ * stride_ - i, dj = to / columns_ * stride_ - j;
  const std::int32_t steps = 2 * std::max(std::abs(di), std::abs(dj));
  for (std::int32_t k = 0; k <= steps; ++k) {
    const auto at = [&](std::int32_t start, std::int32_t d) {  // rounded to the nearest cell
      return static_cast<std::int32_t>(
          std::floor(start + static_cast<double>(k) * d / std::max(steps, 1) + 0.5));
    };
    if (!clear(at(i, di), at(j, dj))) return false;
  }
  return true;
}

std::vector<WanderArea::Node> WanderArea::neighbours(Node node) const {
  std::vector<Node> found;
  const std::int32_t c = node % columns_, r = node / columns_;
  for (std::int32_t dr = -1; dr <= 1; ++dr)
    for (std::int32_t dc = -1; dc <= 1; ++dc) {
      const std::int32_t nc = c + dc, nr = r + dr;
      if ((dc == 0 && dr == 0) || nc < 0 || nr < 0 || nc >= columns_ || nr >= rows_) continue;
      const Node next = nr * columns_ + nc;
      if (open_[static_cast<std::size_t>(next)] != 0 && clear_way(node, next)) found.push_back(next);
    }
  return found;
}

void WanderArea::keep_largest_region() {
  std::vector<std::uint8_t> seen(open_.size());
  for (Node start = 0; start < static_cast<Node>(open_.size()); ++start) {
    if (open_[static_cast<std::size_t>(start)] == 0 || seen[static_cast<std::size_t>(start)] != 0) continue;
    std::vector<Node> region{start};
    seen[static_cast<std::size_t>(start)] = 1;
    for (std::size_t k = 0; k < region.size(); ++k)
      for (const Node next : neighbours(region[k])) {
        if (seen[static_cast<std::size_t>(next)] != 0) continue;
        seen[static_cast<std::size_t>(next)] = 1;
        region.push_back(next);
      }
    if (region.size() > places_.size()) places_ = std::move(region);
  }
  std::sort(places_.begin(), places_.end());
  std::fill(open_.begin(), open_.end(), std::uint8_t{0});
  for (const Node node : places_) open_[static_cast<std::size_t>(node)] = 1;
}

/// The shortest way (Dijkstra) to one of the places between the nearest and the farthest goal, drawn by
/// `word`; if there is none so far, to the farthest there is.
std::vector<WanderArea::Node> WanderArea::way_to_goal(Node from, std::uint32_t word) const {
  const double unit_m = stride_ * resolution_m_ / 5.0;
  struct Reached {
    std::int32_t length;
    Node before;
    bool done;
  };
  std::vector<Reached> reached(open_.size(), {-1, -1, false});
  using Entry = std::pair<std::int32_t, Node>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<Node> goals;
  reached[static_cast<std::size_t>(from)] = {0, -1, false};
  queue.push({0, from});
  Node last = from;
  while (!queue.empty()) {
    const auto [length, node] = queue.top();
    queue.pop();
    Reached& here = reached[static_cast<std::size_t>(node)];
    if (here.done) continue;
    if (length * unit_m > kFarthestGoal_m) break;
    here.done = true;
    last = node;
    if (length * unit_m >= kNearestGoal_m) goals.push_back(node);
    for (const Node next : neighbours(node)) {
      const std::int32_t di = next % columns_ - node % columns_, dj = next / columns_ - node / columns_;
      const std::int32_t further = length + step_length(di, dj);
      Reached& there = reached[static_cast<std::size_t>(next)];
      if (there.length >= 0 && there.length <= further) continue;
      there = {further, node, false};
      queue.push({further, next});
    }
  }
  Node goal = goals.empty() ? last : goals[uniform_below(word, static_cast<std::uint32_t>(goals.size()))];
  std::vector<Node> way;
  for (; goal >= 0; goal = reached[static_cast<std::size_t>(goal)].before) way.push_back(goal);
  std::reverse(way.begin(), way.end());
  return way;
}

/// The way with as few corners as its clearance allows.
std::vector<WanderArea::Node> WanderArea::straightened(const std::vector<Node>& way) const {
  std::vector<Node> corners{way.front()};
  for (std::size_t at = 0; at + 1 < way.size();) {
    std::size_t next = at + 1;
    while (next + 1 < way.size() && clear_way(way[at], way[next + 1])) ++next;
    corners.push_back(way[next]);
    at = next;
  }
  return corners;
}

Waypoint WanderArea::point_of(Node node) const {
  const Pose p = compose(T_map_grid_, {(node % columns_ * stride_ + 0.5) * resolution_m_,
                                       (node / columns_ * stride_ + 0.5) * resolution_m_, 0.0});
  return {p.x_m, p.y_m};
}

WaypointPath WanderArea::wander(double duration_s, double speed_mps, double turn_rate_rad_s,
                                std::uint64_t seed) const {
  WaypointPath path;
  path.name = fmt::format("random drive {}", seed);
  path.speed_mps = speed_mps;
  path.turn_rate_rad_s = turn_rate_rad_s;
  const auto draw = [&](std::uint32_t k) { return philox(k, 0u, Stream::random_drive, 0, seed).w[0]; };
  Node here = places_[uniform_below(draw(0), static_cast<std::uint32_t>(places_.size()))];
  path.points.push_back(point_of(here));
  double time_s = 0.0;
  for (std::uint32_t leg = 1; time_s < duration_s && path.points.size() < kMostPoints; ++leg) {
    const std::vector<Node> corners = straightened(way_to_goal(here, draw(leg)));
    for (std::size_t k = 1; k < corners.size(); ++k) path.points.push_back(point_of(corners[k]));
    here = corners.back();
    time_s = plan_drive(path).duration_s();
  }
  return path;
}

}  // namespace parloc
