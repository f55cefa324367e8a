#include "tools/slam/digested_log.h"

namespace parloc::tools::slam {
namespace {

void add(Sha256& sha, const Pose& pose) {
  sha.add(pose.x_m), sha.add(pose.y_m), sha.add(pose.theta_rad);
}

/// The number of values first, so that none can pass for one of the next array.
template <class Number>
void add(Sha256& sha, const std::vector<Number>& values) {
  sha.add(static_cast<double>(values.size()));
  for (const Number v : values) sha.add(v);
}

void add(Sha256& sha, const Scan& scan) {
  sha.add(static_cast<double>(scan.sensor.size()));
  sha.add(scan.sensor.data(), scan.sensor.size());
  add(sha, scan.T_base_sensor);
  for (const double v : {scan.stamp_s, scan.angle_min_rad, scan.angle_step_rad, scan.range_min_m,
                         scan.range_max_m, scan.scan_time_s})
    sha.add(v);
  add(sha, scan.ranges_m);
  add(sha, scan.bearings_rad);
  add(sha, scan.beam_times_s);
}

}  // namespace

bool DigestedLog::next(LogRecord& record) {
  if (!log_.next(record)) return false;
  const bool is_scan = record.kind == RecordKind::scan;
  sha_.add(is_scan ? 1.0 : 0.0);
  sha_.add(record.stamp_s);
  add(sha_, record.odometry);
  if (is_scan) add(sha_, record.scan);
  return true;
}

}  // namespace parloc::tools::slam
