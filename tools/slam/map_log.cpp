#include "tools/slam/map_log.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/io/scan_stream.h"
#include "tools/report/even_sample.h"
#include "tools/report/machine/machine.h"
#include "tools/report/machine/statistics.h"
#include "tools/slam/checkpoints.h"

namespace parloc::tools::slam {
namespace {

struct Stopped {};

/// Whether it got to the end of that.
bool close_loops(const GridSlam& slam, const MapRequest& request) {
  try {
    slam.close_loops([&](double fraction) {
      if (request.closing) request.closing(fraction);
      if (request.stop && request.stop()) throw Stopped();
    });
  } catch (const Stopped&) {
    return false;
  }
  return true;
}

/// A break leaves loops open: who breaks off does not want to wait.
void finish(const GridSlam& slam, Mapping& m) {
  m.map = m.interrupted ? slam.map_so_far() : slam.map();
  m.trajectory = m.interrupted ? slam.trajectory_so_far() : slam.trajectory();
  m.digest = m.interrupted ? slam.digest_so_far() : slam.digest();
  if (!m.interrupted) m.loops = slam.loops();
  m.records = slam.records();
  m.distinct = slam.distinct_ancestors();
  m.memory = slam.memory();
  m.resident_bytes = tools::peak_resident_bytes();
  m.lidars = slam.lidars_used();
  m.backend = slam.backend_name();
  m.odometry_jumps = slam.odometry_jumps();
  m.scan_odometry = slam.scan_odometry();
  if (m.scan_odometry) m.odometry = slam.odometry();  // its first scan is its origin
}

}  // namespace

Mapping map_log(LogReader& source, const MapRequest& request) {
  DigestedLog log(source);
  ScanStream scans(log, request.config.scan, request.config.lidars, [&](std::size_t) {
    if (request.read) request.read(log.warnings());
  });
  LogRecord record;
  if (!scans.next(record)) throw no_scan(request.log_name, log.warnings());
  Checkpoints checkpoints(request, log);
  GridSlam slam = request.resume != nullptr ? GridSlam(std::move(*request.resume))
                                            : GridSlam(grid_slam_config(request.config));
  checkpoints.check(slam);
  Mapping m;
  m.config = request.config;
  m.step_s = checkpoints.from().step_s;
  m.resumed_at = checkpoints.from().scans;
  m.odometry_chosen = checkpoints.from().odometry_chosen || request.odometry_chosen;
  tools::EvenSample<Growth> growth(22);
  checkpoints.restore(growth);
  double earliest_s = record.stamp_s, latest_s = record.stamp_s;
  const Pose T_odometry_map = record.odometry;
  bool more = true;
  while (more) {
    const bool again = checkpoints.has_next(m.scans);
    if (!again && request.stop && request.stop()) break;
    if (!again) checkpoints.write_when_due(slam, m, growth.kept());
    scans.pass_odometry([&](const StampedPose& reading) {
      if (!again) slam.add_odometry(reading.stamp_s, reading.pose);
    });
    const Clock::time_point step_begun = Clock::now();
    const bool taken_in = !again && slam.step(record.odometry, record.scan);
    if (taken_in) m.step_s.push_back(seconds_since(step_begun));
    ++m.scans;
    earliest_s = std::min(earliest_s, record.stamp_s), latest_s = std::max(latest_s, record.stamp_s);
    m.times.add(record.scan.sensor, record.stamp_s);
    m.odometry.push_back({record.stamp_s, relative(record.odometry, T_odometry_map)});
    if (taken_in) growth.offer([&] { return growth_of(slam, m.scans); });
    if (taken_in && request.watch) request.watch(slam, m.scans);
    if (request.progress) request.progress(log.progress(), m.scans);
    more = scans.next(record);
  }
  if (!more) checkpoints.expect_passed(m.scans);
  m.interrupted = more || !close_loops(slam, request);
  m.warnings = log.warnings();
  m.log_s = latest_s - earliest_s;
  if (m.scans == 0) return m;
  if (m.interrupted) checkpoints.write(slam, m, growth.kept());
  if (m.interrupted && slam.records().empty()) return m;
  if (slam.records().empty())
    throw input_error(
        request.log_name, 0,
        "expected a scan with enough beams to map, found none in " + std::to_string(m.scans) + " scans");
  growth.finish([&] { return growth_of(slam, m.scans); });
  m.growth = growth.take();
  finish(slam, m);
  m.wall_s = checkpoints.wall_s();
  return m;
}

}  // namespace parloc::tools::slam
