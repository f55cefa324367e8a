#include "common/live/live_localizer.h"

#include <mutex>
#include <utility>

#include "common/error.h"
#include "common/filter/pose/pose_guess.h"
#include "common/live/live_scans.h"

namespace parloc {
namespace {

/// After a break the robot is where it was, about: so much less sure.
constexpr double kMoreSigma_m = 0.1, kMoreSigma_rad = 0.05;
/// About each of several places that were possible.
constexpr double kPlaceSigma_m = 0.1, kPlaceSigma_rad = 0.05;

/// A localizer that is to say of the scan taken at `odometry` what another would have said.
void start_as(Localizer& localizer, const LiveAnswer& last, const Pose& odometry, bool looks) {
  const Pose moved = relative(odometry, last.odometry);
  const LocalizerEstimate& before = last.estimate;
  if (before.health.state == HealthState::lost && looks) return localizer.start_anywhere();
  if (before.modes.size() < 2)
    return localizer.start_at(compose(before.filter.pose, moved), before.filter.covariance);
  std::vector<PoseGuess> places;
  for (const Mode& mode : before.modes)
    places.push_back({compose(mode.pose, moved), kPlaceSigma_m, kPlaceSigma_rad, mode.weight});
  localizer.start_at(places);
}

}  // namespace

struct LiveLocalizer::State {
  State(const Config& c, bool odometry_topic)
      : config(c), scans(log_choice(config), odometry_topic, config.scan, config.lidars) {}

  LiveAnswer answer(const LogRecord& record);
  void start(const LiveStart& from);
  void take_over(const Pose& odometry);
  void go_on_somewhere_near();

  mutable std::mutex prepared;  ///< prepare() reads configuration and localizer in another thread.
  Config config;
  std::shared_ptr<Localizer> localizer;
  std::shared_ptr<std::vector<std::string>> warnings;  ///< Of the localizer.
  LiveScans scans;
  std::optional<LiveStart> wanted;  ///< What was said last, as long as no scan has been answered since.
  std::optional<LiveAnswer> last;   ///< Since then.
  bool started = false;
  bool takes_over = false;  ///< The localizer is a new one, and the next scan says where it begins.
};

LiveAnswer LiveLocalizer::State::answer(const LogRecord& record) {
  scans.pass_odometry(
      [&](const StampedPose& reading) { localizer->add_odometry(reading.stamp_s, reading.pose); });
  if (std::exchange(takes_over, false)) take_over(record.odometry);
  LiveAnswer out;
  out.stamp_s = record.stamp_s;
  out.lidar = record.scan.sensor;
  out.odometry = record.odometry;
  out.estimate = localizer->step(record.odometry, record.scan);
  out.T_map_odom = compose(out.estimate.filter.pose, inverse(record.odometry));
  out.why_skipped = localizer->filter().why_skipped();
  last = out;
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
  takes_over = false;
}

/// From where the last answer and the odometry since have the robot.
void LiveLocalizer::State::take_over(const Pose& odometry) {
  try {
    start_as(*localizer, *last, odometry, config.localize.recover);
  } catch (const Error& error) {  // it is not on this map
    if (error.kind() != ErrorKind::input) throw;
    scans.tell(error.what());
    localizer->start_anywhere();
  }
}

/// From about where the last answer, or whoever spoke since, had the robot: odometry does not tell.
void LiveLocalizer::State::go_on_somewhere_near() {
  try {
    if (wanted) return start(*wanted);
    if (!last) return;
    Covariance covariance = last->estimate.filter.covariance;
    for (const int k : {0, 4}) covariance.v[k] += kMoreSigma_m * kMoreSigma_m;
    covariance.v[8] += kMoreSigma_rad * kMoreSigma_rad;
    start({last->estimate.filter.pose, covariance});
  } catch (const Error& error) {  // it is not on this map
    if (error.kind() != ErrorKind::input) throw;
    scans.tell(error.what());
    start({});
  }
}

LiveLocalizer::LiveLocalizer(const Config& config, bool odometry_topic)
    : state_(std::make_unique<State>(config, odometry_topic)) {}
LiveLocalizer::~LiveLocalizer() = default;
LiveLocalizer::LiveLocalizer(LiveLocalizer&&) noexcept = default;
LiveLocalizer& LiveLocalizer::operator=(LiveLocalizer&&) noexcept = default;

PreparedLocalizer LiveLocalizer::prepare(const Config& config, const GridMap& map) const {
  PreparedLocalizer here;
  {
    const std::lock_guard lock(state_->prepared);
    here = {state_->config, state_->localizer, {}, state_->warnings};
  }
  if (here.localizer && config_to_yaml(config) == config_to_yaml(here.config)) {
    here.map = here.localizer->prepare_map(map);
    return here;
  }
  auto warnings = std::make_shared<std::vector<std::string>>();
  Config live = config;
  live.scan.check_stamps = true;
  live.on_warning = [warnings](const std::string& line) { warnings->push_back(line); };
  return {config, std::make_shared<Localizer>(live, map), {}, warnings};
}

void LiveLocalizer::put(PreparedLocalizer prepared) {
  State& s = *state_;
  if (!prepared.localizer) throw Error(ErrorKind::usage, "put: expected what prepare() gave, once");
  if (prepared.map) prepared.localizer->replace_map(std::move(*prepared.map));
  if (prepared.localizer == s.localizer) return;
  {
    const std::lock_guard lock(s.prepared);
    s.config = std::move(prepared.config);
    s.localizer = std::move(prepared.localizer);
    s.warnings = std::move(prepared.warnings);
  }
  if (s.last)
    s.takes_over = true;
  else
    s.go_on_somewhere_near();
}

void LiveLocalizer::start(const LiveStart& start) {
  state_->start(start);
}

bool LiveLocalizer::has_map() const {
  return state_->localizer != nullptr;
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
  if (s.localizer) s.go_on_somewhere_near();
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
