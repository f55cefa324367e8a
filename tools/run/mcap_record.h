// A run as ROS 2 messages, for Foxglove and RViz: --mcap (docs/mcap.md).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/file/output_file.h"
#include "common/map/grid_map.h"
#include "common/mcap/mcap_log.h"
#include "common/model/trajectory.h"
#include "tools/report/even_sample.h"
#include "tools/run/localize_log.h"

namespace parloc::tools {

/// Written as the run goes on; whatever ends it, what is older than about a second is in the file. Reads of
/// the filter only, so that no bit of the run changes. All members throw Error{output}, and Error{input} for
/// stamps that ROS cannot hold.
class McapRecord {
 public:
  /// Nothing is written before the first step. All must outlive it.
  McapRecord(const std::string& path, const GridMap& map, const Trajectory& truth, const Config& config);
  ~McapRecord();  ///< Finishes what was begun, if it can.

  void add(const StepView& step);
  /// Writes the summary; nothing where there was no step.
  void finish();
  std::size_t bytes() const { return file_.size(); }
  std::size_t messages() const { return log_.messages(); }

 private:
  void begin(double stamp_s);
  void write_transforms(const StepView& step);
  void write_scan(const Scan& scan);
  void write_particles(const StepView& step);
  void write_path(const StepView& step);
  void write_truth(double stamp_s);
  void write_health(const ScanAnswer& answer);
  std::string topic_of(const std::string& sensor) const;
  /// Whether `every_s` of the log have gone by since `last_s`, which is then now.
  static bool due(double now_s, double every_s, double& last_s);

  GrowingFile file_;
  const GridMap& map_;
  const Config& config_;
  Trajectory truth_;  ///< By time.
  McapLog log_;
  bool several_lidars_;
  std::string first_lidar_;
  double first_s_ = 0.0;
  double cloud_s_, path_s_;  ///< When they were written last.
  EvenSample<StampedPose> path_;
  std::size_t truth_written_ = 0;  ///< So many rows are past.
  bool finished_ = false;
};

}  // namespace parloc::tools
