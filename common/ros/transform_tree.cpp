#include "common/ros/transform_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/error.h"
#include "common/math/portable64.h"

namespace parloc {

namespace {

constexpr double kRemembered_s = 10.0;
constexpr std::size_t kMostRemembered = 4096;
constexpr std::size_t kMostFrames = 10000;
constexpr std::size_t kMostDeep = 100;

std::string place_text(const RigidTransform& a) {
  const PlanarMount mount = planar_mount(a);
  return fmt::format("({:.3f} m, {:.3f} m, {:.1f} deg{})", mount.T_base_sensor.x_m, mount.T_base_sensor.y_m,
                     mount.T_base_sensor.theta_rad * 180.0 / kPi, mount.upside_down ? ", upside down" : "");
}

/// Differing by more than rounding.
bool differ(const RigidTransform& a, const RigidTransform& b) {
  const double dot = a.qx * b.qx + a.qy * b.qy + a.qz * b.qz + a.qw * b.qw;
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m, a.z_m - b.z_m) > 1e-3 || std::fabs(dot) < 1.0 - 1e-6;
}

}  // namespace

void TransformTree::contradict(const std::string& name, Frame& frame, const RigidTransform& fixed,
                               const RigidTransform& said) {
  if (frame.contradicted || !differ(fixed, said)) return;
  frame.contradicted = true;
  contradictions_.push_back(
      {name, fmt::format("{} sits in {} at {} and at {}: the second is used", printable(name),
                         printable(frame.parent), place_text(fixed), place_text(said))});
}

void TransformTree::add(const TransformMessage& transform, bool is_static) {
  RigidTransform T = transform.T_parent_child;
  const std::string& child = transform.child_frame;
  const std::string& parent = transform.header.frame;
  if (child.empty() || parent.empty() || child == parent || !normalise(T) ||
      (frames_.size() >= kMostFrames && frames_.count(child) == 0)) {
    ++refused_;
    return;
  }
  Frame& frame = frames_[child];
  if (frame.parent != parent) {
    frame = {};
    frame.parent = parent;
  }
  if (is_static) {
    if (frame.fixed) contradict(child, frame, *frame.fixed, T);
    if (!frame.moving.empty()) contradict(child, frame, T, frame.moving.back().T_parent_child);
    frame.fixed = T;
    return;
  }
  if (frame.fixed && frame.moving.empty()) contradict(child, frame, *frame.fixed, T);
  const double stamp_s = transform.header.stamp_s;
  std::deque<Stamped>& known = frame.moving;
  // A clock that was set back starts anew.
  if (!known.empty() && stamp_s < known.front().stamp_s) known.clear();
  auto after = known.end();
  while (after != known.begin() && std::prev(after)->stamp_s > stamp_s) --after;
  known.insert(after, {stamp_s, T});
  while (known.size() > kMostRemembered || known.front().stamp_s < known.back().stamp_s - kRemembered_s)
    known.pop_front();
}

void TransformTree::forget_moving() {
  std::erase_if(frames_, [](const auto& frame) { return !frame.second.fixed; });
  for (auto& [name, frame] : frames_) frame.moving.clear();
}

RigidTransform TransformTree::at(const Frame& frame, double stamp_s) const {
  if (frame.moving.empty()) return frame.fixed.value_or(RigidTransform{});
  const auto later = [](double stamp, const Stamped& s) { return stamp < s.stamp_s; };
  const auto after = std::upper_bound(frame.moving.begin(), frame.moving.end(), stamp_s, later);
  if (after == frame.moving.begin()) return after->T_parent_child;
  const auto before = std::prev(after);
  if (after == frame.moving.end() || before->stamp_s == stamp_s) return before->T_parent_child;
  const double part = (stamp_s - before->stamp_s) / (after->stamp_s - before->stamp_s);
  return blend(before->T_parent_child, after->T_parent_child, part);
}

// The frame, its parent, and so on. Frames in a ring end it.
std::vector<std::string> TransformTree::way_up(const std::string& frame) const {
  std::vector<std::string> way{frame};
  for (auto at = frames_.find(frame); at != frames_.end() && way.size() < kMostDeep;
       at = frames_.find(way.back()))
    way.push_back(at->second.parent);
  return way;
}

std::optional<RigidTransform> TransformTree::find(const std::string& target, const std::string& source,
                                                  double stamp_s) const {
  const std::vector<std::string> from = way_up(source), to = way_up(target);
  const auto in_both = std::find_if(from.begin(), from.end(), [&](const std::string& frame) {
    return std::find(to.begin(), to.end(), frame) != to.end();
  });
  if (in_both == from.end()) return std::nullopt;
  const auto down_to = [&](const std::vector<std::string>& way) {
    RigidTransform T;  // of the way's first frame in the common one
    const auto end = std::find(way.begin(), way.end(), *in_both);
    for (auto frame = way.begin(); frame != end; ++frame) T = compose(at(frames_.at(*frame), stamp_s), T);
    return T;
  };
  return compose(inverse(down_to(to)), down_to(from));
}

bool TransformTree::knows(const std::string& frame) const {
  if (frames_.count(frame) != 0) return true;
  return std::any_of(frames_.begin(), frames_.end(),
                     [&](const auto& entry) { return entry.second.parent == frame; });
}

bool TransformTree::moves(const std::string& frame) const {
  const auto at = frames_.find(frame);
  return at != frames_.end() && !at->second.moving.empty();
}

std::string TransformTree::parent_of(const std::string& frame) const {
  const auto at = frames_.find(frame);
  return at == frames_.end() ? "" : at->second.parent;
}

std::string TransformTree::child_on_the_way(const std::string& ancestor, const std::string& frame) const {
  const std::vector<std::string> way = way_up(frame);
  for (std::size_t k = 1; k < way.size(); ++k)
    if (way[k] == ancestor) return way[k - 1];
  return "";
}

std::vector<std::string> TransformTree::frames() const {
  std::set<std::string> names;
  for (const auto& [child, frame] : frames_) {
    names.insert(child);
    names.insert(frame.parent);
  }
  return {names.begin(), names.end()};
}

}  // namespace parloc
