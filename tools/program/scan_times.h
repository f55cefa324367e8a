// What is odd about the times of a log's scans. None of it ends the work.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace parloc::tools {

class ScanTimes {
 public:
  /// More between two scans is a gap: no LiDAR that maps is so slow.
  static constexpr double kGap_s = 5.0;

  /// Every scan, in the log's order: its LiDAR's name and its stamp.
  void add(const std::string& lidar, double stamp_s);

  std::size_t repeated() const { return repeated_; }  ///< Scans with the stamp of the LiDAR's scan before.
  std::size_t gaps() const { return gaps_; }
  double longest_gap_s() const { return longest_gap_s_; }
  /// One line that says that stamps stand still, or are rounded so that they do for most of the log; empty
  /// if they do not. Up to three scans of one stamp are none of it: LiDARs, or packets, that come together.
  std::string trouble() const;

 private:
  struct Last {
    double stamp_s;
    bool repeated = false;
  };
  std::map<std::string, Last> last_;  ///< By LiDAR.
  std::size_t scans_ = 0, repeated_ = 0, gaps_ = 0;
  std::size_t advances_ = 0;              ///< Scans with a later stamp than the one before, ...
  std::size_t advances_after_block_ = 0;  ///< ... which itself had that of the one before it.
  double shortest_step_s_ = 0.0;          ///< Of those.
  double longest_gap_s_ = 0.0;
};

}  // namespace parloc::tools
