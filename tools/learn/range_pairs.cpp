#include "tools/learn/learn.h"

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/filter/filter_backend.h"

namespace parloc::tools {
namespace {

/// Expected ranges by the backend's own ray_trace, for one pose at a time.
class OneRobot {
 public:
  OneRobot(const GridMap& map, const FilterConfig& config)
      : map_(map), config_(config), track_(config.motion) {
    SensorConfig sensor = config.sensor;
    if (!casts_rays(sensor.model)) sensor.model = SensorModel::beam;
    FilterBackendConfig one;
    one.particles = one.threads = 1;
    one.sensor = sensor;
    backend_ = make_cpu_filter_backend(one);
    backend_->set_map(map);
  }

  /// Every reading in the log's order, those of scans too: for scans that take time.
  void move(double stamp_s, const Pose& odometry) { track_.add(stamp_s, odometry); }

  void look(const Scan& scan, const Pose& pose, RangePairs& ranges) {
    const LidarSetup setup = lidar_setup(scan, config_.scan, find_lidar(config_.lidars, scan.sensor));
    const bool deskew = takes_time(scan, setup) && track_.knows_motion();
    select_beams(scan, setup, deskew ? &track_ : nullptr, config_.sensor, map_.resolution_m, beams_, counts_);
    if (beams_.count == 0) return;
    if (ranges.pairs.empty()) ranges.range_max_m = beams_.range_max_m;
    if (static_cast<double>(beams_.range_max_m) != ranges.range_max_m)
      throw Error(ErrorKind::input, "learn: expected one maximum range in the whole log, found two");
    const Pose at = relative(pose, map_.T_map_grid);
    backend_->upload({{static_cast<float>(at.x_m)},
                      {static_cast<float>(at.y_m)},
                      {static_cast<float>(at.theta_rad)},
                      {0.0f}});
    backend_->set_scan(beams_);
    const std::vector<float> expected_m = backend_->ray_trace();
    for (std::size_t m = 0; m < beams_.count; ++m) ranges.pairs.push_back({beams_.range_m[m], expected_m[m]});
  }

 private:
  const GridMap& map_;
  const FilterConfig& config_;
  std::unique_ptr<FilterBackend> backend_;
  BeamTable beams_;
  BeamCounts counts_;
  OdometryTrack track_;
};

}  // namespace

RangePairsOfLog collect_range_pairs(const GridMap& map, LogReader& log, const Trajectory& poses,
                                    const FilterConfig& config,
                                    const std::function<bool(double fraction)>& keep_going) {
  std::vector<LogRecord> records;
  std::vector<double> stamps_s;
  for (LogRecord record; log.next(record);) {
    stamps_s.push_back(record.stamp_s);
    records.push_back(std::move(record));
  }
  const std::vector<std::optional<Pose>> pose = truth_at(poses, stamps_s);
  RangePairsOfLog result;
  OneRobot robot(map, config);
  for (std::size_t k = 0; k < records.size(); ++k) {
    robot.move(records[k].stamp_s, records[k].odometry);
    if (records[k].kind != RecordKind::scan) continue;
    ++result.scans;
    result.odometry.push_back({records[k].stamp_s, records[k].odometry});
    if (pose[k])
      robot.look(records[k].scan, *pose[k], result.ranges);
    else
      ++result.without_pose;
    if (keep_going && !keep_going(static_cast<double>(k + 1) / static_cast<double>(records.size()))) break;
  }
  return result;
}

}  // namespace parloc::tools
