// The library example of README.md, as a test: a made-up room, a made-up scan, and the pose that explains it.
#include <parloc/parloc.h>

#include <cmath>
#include <cstdio>
#include <string>
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

}  // namespace

int main() try {
  const parloc::GridMap map = room();
  const parloc::Pose truth{5.3, 1.7, 0.4};

  parloc::FilterConfig config;  // every setting has a default
  config.backend = parloc::BackendChoice::cpu;
  config.particles = 2000;
  config.sensor.tempering = 0.3;  // the scan is clean: trust it more than a real one
  parloc::ParticleFilter filter(config, map);
  filter.start_at({5.5, 1.5, 0.3}, 0.3, 0.3, 0.2);

  // The wheels say that the robot creeps forward; each time the scan says where it is.
  parloc::Pose odometry;
  parloc::Estimate estimate;
  parloc::Pose here = truth;
  for (int step = 0; step < 20; ++step) {
    odometry.x_m = 0.05 * step;
    here = parloc::compose(truth, odometry);
    estimate = filter.step(odometry, look_around(map, here));
  }

  const double error_m = std::hypot(estimate.pose.x_m - here.x_m, estimate.pose.y_m - here.y_m);
  const double error_rad = std::abs(std::remainder(estimate.pose.theta_rad - here.theta_rad, 2 * kPi));
  std::printf("parloc, %s: %.3f m and %.2f degrees off\n", filter.backend_name().c_str(), error_m,
              error_rad * 180 / kPi);
  // Half a cell and a degree: a wrong frame, sign or unit is off by far more.
  return error_m < 0.05 && error_rad < 0.0175 && !estimate.lost ? 0 : 1;
} catch (const parloc::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return static_cast<int>(error.kind());
}
