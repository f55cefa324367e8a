// What is odd about the times of a log's scans; none of it ends the work.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace parloc::tools::slam {

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
