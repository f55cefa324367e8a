// Gives scans that came without odometry the odometry at their time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/model/trajectory.h"

namespace parloc {

/// Scans and odometry readings go in as they were recorded, and come out in the order of their stamps: each
/// scan with the odometry at its stamp, between the readings before and after it (straight, and by the
/// shorter turn), exactly a reading's where one has the scan's stamp. That reading does not come out a second
/// time. Deterministic on every machine. Memory: some seconds of readings, at most 20,000, and 1,000 scans.
class OdometryJoiner {
 public:
  /// `live`: readings come out as soon as they are in, unless a scan of before waits; without, some seconds
  /// later, so that a scan that is slow to arrive still comes out before them. And fewer scans are kept.
  explicit OdometryJoiner(bool live = false) : live_(live) {}

  void add_odometry(double stamp_s, const Pose& odometry, std::size_t line);
  void add_scan(LogRecord scan);
  /// No more comes.
  void finish() { finished_ = true; }
  /// False: more has to go in first, or there is no more.
  bool next(LogRecord& record);

  std::size_t scans_before() const { return before_; }  ///< Left out: older than any reading.
  std::size_t scans_after() const { return after_; }    ///< Left out: younger than the last reading.
  /// One line for the scans before, one for those after, if there are any.
  std::vector<std::string> left_out(const std::string& log_name) const;
  std::size_t waiting() const { return scans_.size(); }
  std::size_t remembered() const { return readings_.size(); }  ///< Readings.
  /// Why no scan came out though scans and the end went in: one line with both times.
  std::string why_none() const;
  double longest_gap_s() const { return longest_gap_s_; }  ///< Between two readings with a scan between.

 private:
  struct Reading {
    double stamp_s;
    Pose odometry;
    std::size_t line;
  };
  bool give_reading(double before_s, LogRecord& record);
  void forget();
  bool join(LogRecord& scan);

  bool live_;
  std::deque<Reading> readings_;  ///< In the order of their stamps.
  std::size_t given_ = 0;         ///< The first so many of them have come out, or lie before a scan that has.
  std::deque<LogRecord> scans_;
  bool finished_ = false;
  std::size_t before_ = 0, after_ = 0, stale_in_a_row_ = 0;
  double longest_gap_s_ = 0.0;
  struct Times {
    double first_s = 0.0, last_s = 0.0;
    bool any = false;
    void add(double stamp_s) {
      first_s = any ? std::min(first_s, stamp_s) : stamp_s;
      last_s = any ? std::max(last_s, stamp_s) : stamp_s;
      any = true;
    }
  };
  Times odometry_times_, scan_times_;
};

}  // namespace parloc
