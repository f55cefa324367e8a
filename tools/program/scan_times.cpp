#include "tools/program/scan_times.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/model/continuous_odometry.h"

namespace parloc::tools {

void ScanTimes::add(const std::string& lidar, double stamp_s) {
  ++scans_;
  const auto [found, first] = last_.try_emplace(lidar, Last{stamp_s});
  if (first) return;
  Last& last = found->second;
  const double time_s = stamp_s - last.stamp_s;
  if (time_s > 0.0) ++advances_;
  if (time_s > 0.0 && last.repeated) {
    shortest_step_s_ = advances_after_block_ == 0 ? time_s : std::min(shortest_step_s_, time_s);
    ++advances_after_block_;
  }
  last = {stamp_s, time_s == 0.0};
  repeated_ += last.repeated ? 1 : 0;
  gaps_ += time_s > kGap_s ? 1 : 0;
  longest_gap_s_ = std::max(longest_gap_s_, time_s);
}

std::string ScanTimes::trouble() const {
  if (3 * repeated_ <= 2 * scans_) return "";
  const std::string how_many =
      fmt::format("{} of {} scans have the stamp of the scan before", repeated_, scans_);
  // A clock that dies goes on from scan to scan until then; rounded stamps go on from block to block.
  if (advances_after_block_ < 2 || 2 * advances_after_block_ <= advances_)
    return fmt::format("stamps stand still: {}; times are guessed ({} s each)", how_many,
                       ContinuousOdometry::kGuess_s);
  return fmt::format(
      "stamps look rounded: {}, then come steps of {:.6g} s or more; times between are guessed ({} s each)",
      how_many, shortest_step_s_, ContinuousOdometry::kGuess_s);
}

}  // namespace parloc::tools
