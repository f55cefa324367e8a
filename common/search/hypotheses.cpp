#include "common/search/hypotheses.h"

#include <algorithm>
#include <functional>

#include "common/math/portable64.h"

namespace parloc {
namespace {

LatticePose pose_of_key(std::uint64_t key, std::int32_t width, std::int32_t height) {
  const std::uint64_t index = kLastPose - (key & kLastPose);
  const auto w = static_cast<std::uint64_t>(width), h = static_cast<std::uint64_t>(height);
  return {static_cast<std::int32_t>(index % w), static_cast<std::int32_t>(index / w % h),
          static_cast<std::int32_t>(index / w / h), static_cast<std::uint32_t>(key >> 40)};
}

}  // namespace

bool separated(const Pose& a, const Pose& b, const Separation& s) {
  const double dx = a.x_m - b.x_m, dy = a.y_m - b.y_m;
  return dx * dx + dy * dy >= s.distance_m * s.distance_m || turn_rad(a, b) >= s.angle_rad;
}

Pose pose_of(const LatticePose& p, std::int32_t headings, double cell_m) {
  return {(p.i + 0.5) * cell_m, (p.j + 0.5) * cell_m, wrap64(2.0 * kPi * p.k / headings)};
}

std::vector<LatticePose> separate(std::vector<std::uint64_t>& keys, std::int32_t width, std::int32_t height,
                                  std::int32_t headings, double cell_m, const Separation& separation,
                                  std::size_t most) {
  std::sort(keys.begin(), keys.end(), std::greater<>());
  std::vector<LatticePose> taken;
  std::vector<Pose> poses;
  for (const std::uint64_t key : keys) {
    if (taken.size() >= most) break;
    const LatticePose p = pose_of_key(key, width, height);
    const Pose pose = pose_of(p, headings, cell_m);
    const auto apart = [&](const Pose& other) { return separated(pose, other, separation); };
    if (!std::all_of(poses.begin(), poses.end(), apart)) continue;
    taken.push_back(p);
    poses.push_back(pose);
  }
  return taken;
}

}  // namespace parloc
