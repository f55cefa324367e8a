// The breaks in the mapping of a log: checkpoints that are written on the way, and the one it goes on from.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "common/io/log.h"
#include "common/math/sha256.h"
#include "tools/report/even_sample.h"
#include "tools/slam/map_log.h"
#include "tools/slam/map_position.h"

namespace parloc::tools::slam {

/// Passes another log's records on, and digests them: what a run depends on, not how the file spells it.
class DigestedLog final : public LogReader {
 public:
  explicit DigestedLog(LogReader& log) : log_(log) {}
  bool next(LogRecord& record) override;
  const LogWarnings& warnings() const override { return log_.warnings(); }
  double progress() const override { return log_.progress(); }
  /// Of all records so far, in hexadecimal.
  std::string digest() const { return sha_.hex(); }

 private:
  LogReader& log_;
  Sha256 sha_;
};

class Checkpoints {
 public:
  /// To be made before the request's checkpoint is used up. `log`: what of it is read must be the same.
  Checkpoints(const MapRequest& request, const DigestedLog& log);

  /// Whether the filter that goes on is one that this could be of. Throws Error{input}.
  void check(const GridSlam& slam) const;
  /// Where the checkpoint stands; all zero without one.
  const MapPosition& from() const { return from_; }
  /// What had been kept to be shown. Throws Error{input}.
  void restore(tools::EvenSample<Growth>& growth);
  /// Whether the checkpoint has the next scan, after so many, in it: then only the log is to be read again.
  /// Throws Error{input} once the log is seen to be another.
  bool has_next(std::size_t scans) const;
  /// The log is at its end. Throws likewise.
  void expect_passed(std::size_t scans) const;

  void write_when_due(const GridSlam& slam, const Mapping& m, const std::vector<Growth>& growth);
  void write(const GridSlam& slam, const Mapping& m, const std::vector<Growth>& growth);
  /// That has gone by, in all parts together.
  double wall_s() const;

 private:
  void expect_same(std::size_t scans) const;
  using Clock = std::chrono::steady_clock;

  const MapRequest& request_;
  const DigestedLog& log_;
  std::string name_;  ///< Of the checkpoint that it goes on from.
  MapPosition from_;
  double pause_s_;
  Clock::time_point begun_ = Clock::now(), written_ = begun_;
};

}  // namespace parloc::tools::slam
