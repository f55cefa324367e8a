// The library examples of README.md, docs/localize.md and docs/slam.md, as a test: a made-up room, a made-up
// scan, and the pose that explains it, with a start pose, without one, as on a robot, and from one scan
// alone; then the room itself, from scans and wheels.
#include <parloc/parloc.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

constexpr double kPi = 3.14159265358979323846;

// A room of 8 m x 5 m with a pillar that makes its four corners different.
parloc::GridMap room() {
  std::vector<std::string> rows(50, "#" + std::string(78, '.') + "#");
  rows.front() = rows.back() = std::string(80, '#');
  for (int row = 10; row < 20; ++row) rows[static_cast<std::size_t>(row)].replace(20, 10, 10, '#');
  return parloc::grid_from_text(rows, 0.1);
}

// What a LiDAR with 180 beams would see: walks each beam in steps of a millimetre.
parloc::Scan look_around(const parloc::GridMap& map, const parloc::Pose& pose) {
  parloc::Scan scan;
  scan.angle_step_rad = 2 * kPi / 180;
  scan.range_min_m = 0.1;
  scan.range_max_m = 20.0;
  for (int beam = 0; beam < 180; ++beam) {
    const double angle_rad = pose.theta_rad + beam * scan.angle_step_rad;
    double range_m = 0.0;
    while (map.at_point(pose.x_m + range_m * std::cos(angle_rad), pose.y_m + range_m * std::sin(angle_rad)) ==
           parloc::Cell::free) {
      range_m += 0.001;
    }
    scan.ranges_m.push_back(static_cast<float>(range_m));
  }
  return scan;
}

const parloc::Pose kTruth{5.3, 1.7, 0.4};

// Half a cell and a degree: a wrong frame, sign or unit is off by far more.
bool is_near(const char* what, const parloc::Pose& pose, const parloc::Pose& truth) {
  const double error_m = std::hypot(pose.x_m - truth.x_m, pose.y_m - truth.y_m);
  const double error_rad = std::abs(std::remainder(pose.theta_rad - truth.theta_rad, 2 * kPi));
  std::printf("%s: %.3f m and %.2f degrees off\n", what, error_m, error_rad * 180 / kPi);
  return error_m < 0.05 && error_rad < 0.0175;
}

// The wheels say that the robot creeps forward; each time the scan says where it is.
parloc::Pose creep(int step) {
  return {0.05 * step, 0.0, 0.0};
}

bool follows(const parloc::FilterConfig& config, const parloc::GridMap& map) {
  parloc::ParticleFilter filter(config, map);
  filter.start_at({5.5, 1.5, 0.3}, 0.3, 0.3, 0.2);
  parloc::Estimate estimate;
  parloc::Pose here;
  for (int step = 0; step < 20; ++step) {
    here = parloc::compose(kTruth, creep(step));
    estimate = filter.step(creep(step), look_around(map, here));
  }
  return is_near(filter.backend_name().c_str(), estimate.pose, here) && !estimate.lost;
}

bool finds_itself(const parloc::LocalizerConfig& config, const parloc::GridMap& map) {
  parloc::Localizer localizer(config, map);
  localizer.start_anywhere();
  parloc::LocalizerEstimate estimate;
  parloc::Pose here;
  for (int step = 0; step < 20; ++step) {
    here = parloc::compose(kTruth, creep(step));
    parloc::Scan scan = look_around(map, here);
    scan.stamp_s = 0.2 * step;
    estimate = localizer.step(creep(step), scan);
  }
  return is_near("found", estimate.filter.pose, here) &&
         estimate.health.state == parloc::HealthState::tracking;
}

// As on a robot: odometry ten times as often as scans, a LiDAR upside down at the back that only the settings
// know of, a scan that comes twice, a pose between scans, an operator's word, and another map, made ready
// beside.
bool lives(parloc::LocalizerConfig config, const parloc::GridMap& map) {
  const parloc::Pose mount{-0.2, 0.0, 3.0};
  config.lidars = {
      {.name = "rear", .x = mount.x_m, .y = mount.y_m, .yaw = mount.theta_rad, .upside_down = true}};
  config.scan.check_stamps = true;
  std::size_t warnings = 0;
  config.on_warning = [&](const std::string& text) {
    ++warnings, std::printf("warning: %s\n", text.c_str());
  };
  parloc::Localizer localizer(config, map);
  const double ros[36] = {0.04, 0.01, 0, 0, 0, 0, 0.01, 0.04};  // and a heading that is known
  localizer.start_at(kTruth, parloc::covariance_from_ros(ros));

  parloc::LocalizerEstimate said;
  parloc::Scan scan;
  int step = 0;
  const auto drive_to = [&](int to) {
    for (; step < to; ++step) {
      localizer.add_odometry(0.02 * step, creep(step));
      if (step % 10 != 0) continue;
      scan = look_around(map, parloc::compose(parloc::compose(kTruth, creep(step)), mount));
      std::reverse(scan.ranges_m.begin() + 1, scan.ranges_m.end());
      scan.sensor = "rear";
      scan.stamp_s = 0.02 * step;
      said = localizer.step(scan);
    }
    return parloc::compose(kTruth, creep(to - 1));
  };
  const parloc::Pose here = drive_to(25);
  const bool between = is_near("between scans", localizer.predict(0.02 * 24).mean, here);
  const bool refused = !localizer.step(scan).filter.weighted && !localizer.filter().why_skipped().empty();

  std::optional<parloc::Localizer::PreparedMap> next;
  parloc::GridMap other = map;  // the pillar is gone
  for (parloc::Cell& cell : other.cells) cell = parloc::Cell::free;
  for (std::int32_t i = 0; i < map.width; ++i)
    for (const std::int32_t j : {0, map.height - 1}) other.cells[map.index(i, j)] = parloc::Cell::occupied;
  for (std::int32_t j = 0; j < map.height; ++j)
    for (const std::int32_t i : {0, map.width - 1}) other.cells[map.index(i, j)] = parloc::Cell::occupied;
  std::thread([&] { next = localizer.prepare_map(other); }).join();
  localizer.replace_map(std::move(*next));
  const parloc::Pose later = drive_to(31);
  localizer.relocate(later, said.filter.covariance);
  try {
    other.cells.pop_back();
    localizer.replace_map(other);
  } catch (const parloc::Error& error) {
    std::printf("refused: %s\n", error.what());
    return between && refused && warnings == 0 && is_near("on", said.filter.pose, later);
  }
  return false;
}

// One scan is worth a cell and two degrees.
bool is_located(const parloc::LocalizerConfig& config, const parloc::GridMap& map) {
  parloc::GlobalSearch search(map, config.search, config);
  const parloc::SearchResult result = search.search(look_around(map, kTruth), config);
  if (result.hypotheses.empty() || result.ambiguous) return false;
  const parloc::Pose& best = result.hypotheses[0].pose;
  std::printf("located: (%.2f, %.2f, %.2f)\n", best.x_m, best.y_m, best.theta_rad);
  return std::hypot(best.x_m - kTruth.x_m, best.y_m - kTruth.y_m) < 0.1 &&
         std::abs(best.theta_rad - kTruth.theta_rad) < 0.035;
}

// Without a map: 3.6 m along the room, by wheels that count 3 % too much. The map is as large as the room,
// and the wheels' 11 cm are put right to about a cell.
bool is_mapped(parloc::GridSlamConfig config, const parloc::GridMap& room_map) {
  config.slam.particles = 10;
  parloc::GridSlam slam(config);
  const parloc::Pose start{1.5, 1.2, 0.0};
  parloc::Pose moved;
  for (int step = 0; step <= 12; ++step) {
    moved = {0.3 * step, 0.0, 0.0};
    parloc::Scan scan = look_around(room_map, parloc::compose(start, moved));
    scan.stamp_s = step;
    slam.step({1.03 * moved.x_m, 0.0, 0.0}, scan);
  }
  const parloc::GridMap map = slam.map();
  const double width_m = map.width * map.resolution_m, height_m = map.height * map.resolution_m;
  const parloc::Trajectory trajectory = slam.trajectory();
  std::printf("mapped: %d x %d cells, %.2f x %.2f m\n", map.width, map.height, width_m, height_m);
  return trajectory.size() == 13 && is_near("trajectory", trajectory.back().pose, moved) &&
         std::abs(width_m - 8.0) < 0.3 && std::abs(height_m - 5.0) < 0.3;
}

}  // namespace

int main() try {
  const parloc::GridMap map = room();
  parloc::Config config;  // every setting has a default
  config.backend = parloc::BackendChoice::cpu;
  config.particles = 2000;
  config.sensor.tempering = 0.3;  // the scan is clean: trust it more than a real one
  const bool all = follows(config, map) && finds_itself(config, map) && lives(config, map) &&
                   is_located(config, map) && is_mapped(parloc::grid_slam_config(config), map);
  return all ? 0 : 1;
} catch (const parloc::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return static_cast<int>(error.kind());
}
