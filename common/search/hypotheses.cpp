#include "common/search/hypotheses.h"

#include <algorithm>

#include "common/math/portable64.h"
#include "common/search/search_work.h"

namespace parloc {
bool separated(const Pose& a, const Pose& b, const Separation& s) {
  const double dx = a.x_m - b.x_m, dy = a.y_m - b.y_m;
  return dx * dx + dy * dy >= s.distance_m * s.distance_m || turn_rad(a, b) >= s.angle_rad;
}

Pose pose_of(const LatticePose& p, std::int32_t headings, double cell_m) {
  return {(p.i + 0.5) * cell_m, (p.j + 0.5) * cell_m, wrap64(2.0 * kPi * p.k / headings)};
}

void SeparatePoses::begin(const SearchGrid& grid, std::int32_t headings, double cell_m,
                          const Separation& separation, std::size_t most) {
  width_ = grid.width, height_ = grid.height, headings_ = headings;
  cell_m_ = cell_m;
  separation_ = separation;
  most_ = most;
  in_order_ = 0;
  done_ = false;
  keys.clear();
  taken_.clear();
  poses_.clear();
}

LatticePose SeparatePoses::pose_of_key(std::uint64_t key) const {
  const std::uint64_t index = kLastPose - (key & kLastPose);
  const auto w = static_cast<std::uint64_t>(width_), h = static_cast<std::uint64_t>(height_);
  return {static_cast<std::int32_t>(index % w), static_cast<std::int32_t>(index / w % h),
          static_cast<std::int32_t>(index / w / h), static_cast<std::uint32_t>(key >> 40)};
}

/// Only the best of many keys are ever looked at: a heap, which grows by one key at a time, costs less than
/// sorting them all, and its slices are as short as anybody likes.
std::int64_t SeparatePoses::advance(std::int64_t work) {
  std::int64_t spent = 0;
  while (in_order_ < keys.size() && (spent == 0 || spent < work)) {
    ++in_order_;
    std::push_heap(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(in_order_));
    spent += search_work::kSortedKey;
  }
  if (in_order_ < keys.size()) return spent;
  while (!done_ && (spent == 0 || spent < work)) {
    done_ = keys.empty() || taken_.size() >= most_;
    if (!done_) spent += take_best();
  }
  return spent;
}

std::int64_t SeparatePoses::take_best() {
  std::pop_heap(keys.begin(), keys.end());
  const LatticePose p = pose_of_key(keys.back());
  keys.pop_back();
  in_order_ = keys.size();
  const Pose pose = pose_of(p, headings_, cell_m_);
  const auto compared = static_cast<std::int64_t>(poses_.size());
  const auto apart = [&](const Pose& other) { return separated(pose, other, separation_); };
  if (std::all_of(poses_.begin(), poses_.end(), apart)) {
    taken_.push_back(p);
    poses_.push_back(pose);
  }
  return search_work::kTakenKey + search_work::kComparedPose * compared;
}

}  // namespace parloc
