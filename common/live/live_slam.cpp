#include "common/live/live_slam.h"

#include "common/error.h"
#include "common/live/live_scans.h"

namespace parloc {

struct LiveSlam::State {
  State(const Config& c, bool odometry_topic)
      : config(grid_slam_config(c)),
        slam(config),
        scans(log_choice(c), odometry_topic, config.scan, config.lidars) {}

  LiveSlamAnswer answer(const LogRecord& record);

  GridSlamConfig config;
  GridSlam slam;
  LiveScans scans;
  Pose T_map_odom;  ///< At the last scan that was taken in.
};

LiveSlamAnswer LiveSlam::State::answer(const LogRecord& record) {
  scans.pass_odometry([&](const StampedPose& reading) { slam.add_odometry(reading.stamp_s, reading.pose); });
  LiveSlamAnswer out;
  out.stamp_s = record.stamp_s;
  out.taken_in = slam.step(record.odometry, record.scan);
  if (out.taken_in) T_map_odom = compose(slam.poses()[slam.best()], inverse(record.odometry));
  out.T_map_odom = T_map_odom;
  out.pose = compose(T_map_odom, record.odometry);
  return out;
}

LiveSlam::LiveSlam(const Config& config, bool odometry_topic)
    : state_(std::make_unique<State>(config, odometry_topic)) {}
LiveSlam::~LiveSlam() = default;
LiveSlam::LiveSlam(LiveSlam&&) noexcept = default;
LiveSlam& LiveSlam::operator=(LiveSlam&&) noexcept = default;

void LiveSlam::take(TopicRole role, const std::string& topic, std::string_view bytes) {
  state_->scans.take(role, topic, bytes);
}

std::optional<LiveSlamAnswer> LiveSlam::next() {
  LogRecord record;
  for (;;) {
    if (!state_->scans.next(record)) return std::nullopt;
    try {
      return state_->answer(record);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      state_->scans.tell(error.what());
    }
  }
}

void LiveSlam::forget() {
  state_->scans.forget();
}

std::optional<GridMap> LiveSlam::map_so_far() const {
  if (state_->slam.records().empty()) return std::nullopt;
  return state_->slam.map_so_far();
}

const GridSlam& LiveSlam::slam() const {
  return state_->slam;
}
std::size_t LiveSlam::waiting() const {
  return state_->scans.waiting();
}
std::vector<std::string> LiveSlam::troubles() {
  return state_->scans.troubles();
}

}  // namespace parloc
