// What is odd about a log: odometry that is of no use, and the times of its scans.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "common/config/config.h"
#include "common/io/log.h"

namespace parloc::tools::slam {

constexpr const char* kOdometryFromScans = "the log has no odometry that moves: taken from its scans";

/// Whether a log of two scans or more has the same odometry throughout. Reads only until two readings differ.
bool odometry_stands_still(LogReader& log);
/// Has the odometry taken from the scans where the recorded one, that was to be used, never moves; whether it
/// did so. A log that is not a plain file, and can be read only once, is not looked at.
bool choose_odometry(const std::string& log_path, Config& config);

/// None of what it counts ends the work.
class ScanTimes {
 public:
  /// More between two scans is a gap: no LiDAR that maps is so slow.
  static constexpr double kGap_s = 5.0;

  void add(const std::string& lidar, double stamp_s) {
    const auto [last, first] = last_s_.try_emplace(lidar, stamp_s);
    if (first) return;
    const double time_s = stamp_s - last->second;
    last->second = stamp_s;
    repeated_ += time_s == 0.0 ? 1 : 0;
    gaps_ += time_s > kGap_s ? 1 : 0;
    longest_gap_s_ = time_s > longest_gap_s_ ? time_s : longest_gap_s_;
  }
  std::size_t repeated() const { return repeated_; }  ///< Scans with the stamp of the one before.
  std::size_t gaps() const { return gaps_; }
  double longest_gap_s() const { return longest_gap_s_; }

 private:
  std::map<std::string, double> last_s_;  ///< By LiDAR.
  std::size_t repeated_ = 0, gaps_ = 0;
  double longest_gap_s_ = 0.0;
};

}  // namespace parloc::tools::slam
