#include "common/live/live_localizer.h"

#include <utility>

#include "common/error.h"
#include "common/live/live_scans.h"

namespace parloc {
namespace {

/// After a break the robot is where it was, about: so much less sure.
constexpr double kMoreSigma_m = 0.1, kMoreSigma_rad = 0.05;

}  // namespace

struct LiveLocalizer::State {
  State(const Config& c, bool odometry_topic)
      : config(c), scans(log_choice(config), odometry_topic, config.scan, config.lidars) {}

  LiveAnswer answer(const LogRecord& record);
  void start(const LiveStart& from);
  void go_on();

  Config config;
  std::optional<Localizer> localizer;
  std::shared_ptr<std::vector<std::string>> warnings;  ///< Of the localizer.
  LiveScans scans;
  std::optional<LiveStart> wanted;  ///< What was said last, as long as no scan has been answered since.
  std::optional<Estimate> last;     ///< Since then.
  bool started = false;
};

LiveAnswer LiveLocalizer::State::answer(const LogRecord& record) {
  scans.pass_odometry(
      [&](const StampedPose& reading) { localizer->add_odometry(reading.stamp_s, reading.pose); });
  LiveAnswer out;
  out.stamp_s = record.stamp_s;
  out.lidar = record.scan.sensor;
  out.odometry = record.odometry;
  out.estimate = localizer->step(record.odometry, record.scan);
  out.T_map_odom = compose(out.estimate.filter.pose, inverse(record.odometry));
  out.why_skipped = localizer->filter().why_skipped();
  last = out.estimate.filter;
  wanted.reset();
  return out;
}

void LiveLocalizer::State::start(const LiveStart& from) {
  if (!localizer) {
    wanted = from;
    return;
  }
  if (from.pose_in_map)
    localizer->start_at(*from.pose_in_map, from.covariance);
  else
    localizer->start_anywhere();
  wanted = from;
  last.reset();
  started = true;
}

/// From where the last answer, or whoever spoke since, had the robot.
void LiveLocalizer::State::go_on() {
  started = false;
  try {
    if (wanted) return start(*wanted);
    if (!last) return;
    Covariance covariance = last->covariance;
    for (const int k : {0, 4}) covariance.v[k] += kMoreSigma_m * kMoreSigma_m;
    covariance.v[8] += kMoreSigma_rad * kMoreSigma_rad;
    start({last->pose, covariance});
  } catch (const Error& error) {  // it is not on this map
    scans.tell(error.what());
    start({});
  }
}

LiveLocalizer::LiveLocalizer(const Config& config, bool odometry_topic)
    : state_(std::make_unique<State>(config, odometry_topic)) {}
LiveLocalizer::~LiveLocalizer() = default;
LiveLocalizer::LiveLocalizer(LiveLocalizer&&) noexcept = default;
LiveLocalizer& LiveLocalizer::operator=(LiveLocalizer&&) noexcept = default;

PreparedLocalizer LiveLocalizer::prepare(const Config& config, const GridMap& map) {
  auto warnings = std::make_shared<std::vector<std::string>>();
  Config live = config;
  live.scan.check_stamps = true;
  live.on_warning = [warnings](const std::string& line) { warnings->push_back(line); };
  return {live, Localizer(live, map), warnings};
}

void LiveLocalizer::put(PreparedLocalizer prepared) {
  state_->config = std::move(prepared.config);
  state_->localizer.emplace(std::move(prepared.localizer));
  state_->warnings = std::move(prepared.warnings);
  state_->go_on();
}

void LiveLocalizer::start(const LiveStart& start) {
  state_->start(start);
}

bool LiveLocalizer::has_map() const {
  return state_->localizer.has_value();
}

bool LiveLocalizer::started() const {
  return state_->started;
}

void LiveLocalizer::take(TopicRole role, const std::string& topic, std::string_view bytes) {
  state_->scans.take(role, topic, bytes);
}

std::optional<LiveAnswer> LiveLocalizer::next() {
  State& s = *state_;
  for (LogRecord record;;) {
    try {
      if (!s.scans.next(record)) return std::nullopt;
      if (s.started) return s.answer(record);  // before, nobody knows where it was taken
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      s.scans.tell(error.what());
    }
  }
}

void LiveLocalizer::weigh_next() {
  if (state_->localizer) state_->localizer->weigh_next();
}

void LiveLocalizer::forget() {
  State& s = *state_;
  s.scans.forget();
  if (s.localizer) s.go_on();
}

const Localizer& LiveLocalizer::localizer() const {
  if (!state_->localizer) throw Error(ErrorKind::usage, "there is no localizer before there is a map");
  return *state_->localizer;
}

std::size_t LiveLocalizer::waiting() const {
  return state_->scans.waiting();
}

std::vector<std::string> LiveLocalizer::troubles() {
  State& s = *state_;
  if (s.warnings)
    for (const std::string& line : std::exchange(*s.warnings, {})) s.scans.tell(line);
  return s.scans.troubles();
}

}  // namespace parloc
