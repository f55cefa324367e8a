#include "common/live/live_localizer.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/error.h"
#include "common/inputs/live_log.h"
#include "common/io/scan_stream.h"

namespace parloc {
namespace {

/// After the clock was set the robot is where it was, about.
constexpr double kLeastSigma_m = 0.1, kLeastSigma_rad = 0.05;

}  // namespace

struct LiveLocalizer::State {
  State(const Config& c, bool odometry_topic) : config(c), log("robot", log_choice(config), odometry_topic) {
    forget();
  }

  void forget() { scans.emplace(log, config.scan, config.lidars, [](std::size_t) {}); }
  LiveAnswer answer(const LogRecord& record);
  void start(const LiveStart& from);
  void go_on();
  void tell(const std::string& line);

  Config config;
  std::optional<Localizer> localizer;
  LiveLog log;
  std::optional<ScanStream> scans;
  std::optional<LiveStart> wanted;  ///< What was said last, as long as no scan has been answered since.
  std::optional<Estimate> last;     ///< Since then.
  bool started = false;
  std::size_t troubles = 0;     ///< Of the log, that were looked at.
  std::set<std::string> known;  ///< Lines that were told, without their numbers.
  std::vector<std::string> told;
};

LiveAnswer LiveLocalizer::State::answer(const LogRecord& record) {
  scans->pass_odometry(
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
    localizer->start_at(*from.pose_in_map, from.sigma_x_m, from.sigma_y_m, from.sigma_theta_rad);
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
    const double* variance = last->covariance.v;
    const double sigma_m = std::max(std::sqrt(std::max(variance[0], variance[4])), kLeastSigma_m);
    start({last->pose, sigma_m, sigma_m, std::max(std::sqrt(variance[8]), kLeastSigma_rad)});
  } catch (const Error& error) {  // it is not on this map
    tell(error.what());
    start({});
  }
}

/// Once, whatever numbers are in it: of a hundred bad messages the first is told.
void LiveLocalizer::State::tell(const std::string& line) {
  constexpr std::size_t most = 1000;
  std::string key = line;
  std::erase_if(key, [](char c) { return c >= '0' && c <= '9'; });
  if (known.size() < most && known.insert(key).second) told.push_back(line);
}

LiveLocalizer::LiveLocalizer(const Config& config, bool odometry_topic)
    : state_(std::make_unique<State>(config, odometry_topic)) {}
LiveLocalizer::~LiveLocalizer() = default;
LiveLocalizer::LiveLocalizer(LiveLocalizer&&) noexcept = default;
LiveLocalizer& LiveLocalizer::operator=(LiveLocalizer&&) noexcept = default;

PreparedLocalizer LiveLocalizer::prepare(const Config& config, const GridMap& map) {
  return {config, Localizer(config, map)};
}

void LiveLocalizer::put(PreparedLocalizer prepared) {
  state_->config = std::move(prepared.config);
  state_->localizer.emplace(std::move(prepared.localizer));
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
  state_->log.take(role, topic, bytes);
}

std::optional<LiveAnswer> LiveLocalizer::next() {
  State& s = *state_;
  for (LogRecord record;;) {
    try {
      if (!s.scans->next(record)) return std::nullopt;
      if (s.started) return s.answer(record);  // before, nobody knows where it was taken
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::input) throw;
      s.tell(error.what());
    }
  }
}

void LiveLocalizer::weigh_next() {
  if (state_->localizer) state_->localizer->weigh_next();
}

void LiveLocalizer::forget() {
  State& s = *state_;
  s.log.forget();
  s.forget();
  if (s.localizer) s.go_on();
}

const Localizer& LiveLocalizer::localizer() const {
  if (!state_->localizer) throw Error(ErrorKind::usage, "there is no localizer before there is a map");
  return *state_->localizer;
}

std::size_t LiveLocalizer::waiting() const {
  return state_->log.waiting();
}

std::vector<std::string> LiveLocalizer::troubles() {
  State& s = *state_;
  if (std::exchange(s.troubles, s.log.troubles()) != s.log.troubles()) {
    const LogWarnings& now = s.log.warnings();
    for (const LogNote& note : now.notes) s.tell(note.lidar + ": " + note.text);
    for (const std::string& line : now.messages) s.tell(line);
  }
  return std::exchange(s.told, {});
}

}  // namespace parloc
