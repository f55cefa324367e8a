#include "common/eval/families/drawn_drive.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "common/math/angle_units.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kTicksPerSecond = 200.0;  // the simulator's stamps
constexpr double kLongestStep_m = 1.5,
                 kLongestTurn_rad = 0.7;  // from scan to scan, where steps are no trouble
constexpr double kSpeedPerSide_hz =
    0.1;  // who needs less than 10 s for the whole place would not drive so fast there

/// One random number after the other, each with a counter of its own.
class Dice {
 public:
  Dice(Family family, std::uint64_t seed) : family_(family), seed_(seed) {}

  double uniform(double low, double high) {
    return low + static_cast<double>(uniform_unit(next().w[0])) * (high - low);
  }
  double log_uniform(double low, double high) {
    return std::clamp(portable_exp64(uniform(portable_log64(low), portable_log64(high))), low, high);
  }
  double normal() { return static_cast<double>(normals(next()).n[0]); }
  double sign() { return uniform_below(next().w[0], 2) == 0 ? -1.0 : 1.0; }
  std::size_t below(std::size_t n) { return uniform_below(next().w[0], static_cast<std::uint32_t>(n)); }
  bool happens(double probability) { return uniform(0.0, 1.0) < probability; }

 private:
  Philox4x32 next() {
    return philox(count_++, static_cast<std::uint32_t>(family_), Stream::drawn_drive, 0u, seed_);
  }

  Family family_;
  std::uint64_t seed_;
  std::uint32_t count_ = 0;
};

std::size_t draw_place(Family family, Dice& dice) {
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    const PlaceFacts& facts = kPlaces[k];
    const bool rooms = facts.name == "office" || facts.name == "works";
    const bool wide = facts.name == "works" || facts.name == "ice_world" || facts.name == "square_ring";
    const bool fits = family == Family::doors                                        ? rooms
                      : family == Family::fast                                       ? wide
                      : family == Family::furniture_moved || family == Family::scale ? facts.cells
                                                                                     : true;
    if (fits) places.push_back(k);
  }
  const std::size_t drawn = places[dice.below(places.size())];  // in any case: the same numbers follow
  return family == Family::corridor ? kCorridor : drawn;
}

std::size_t draw_other_place(std::size_t place, Dice& dice) {
  return (place + 1 + dice.below(kPlaces.size() - 1)) % kPlaces.size();
}

/// How fast it drives and scans [m/s, Hz].
struct Pace {
  double speed_mps, scan_hz;
};

Pace draw_pace(Family family, std::size_t place, Dice& dice) {
  const double side_m = place == kCorridor ? 20.0 : kPlaces[place].side_m;
  const double fastest = std::min(7.0, kSpeedPerSide_hz * side_m);
  if (family == Family::fast) {
    const double speed = dice.log_uniform(2.5, std::min(7.0, 2.0 * kSpeedPerSide_hz * side_m));
    return {speed, dice.log_uniform(std::max(1.0, speed / kLongestStep_m), 40.0)};
  }
  if (family == Family::long_steps) {
    const double speed = dice.log_uniform(0.3, fastest);
    return {speed, speed / dice.uniform(1.0, 2.5)};
  }
  const double scan_hz = family == Family::slow_scans ? dice.uniform(1.0, 2.0)
                         : family == Family::standing ? dice.log_uniform(1.0, 5.0)
                                                      : dice.log_uniform(1.0, 40.0);
  return {dice.log_uniform(0.05, std::min(fastest, kLongestStep_m * scan_hz)), scan_hz};
}

/// Scans come every whole number of ticks, odometry with them and up to 100 times a second in between.
void set_rates(double scan_hz, Dice& dice, Scenario& robot) {
  const int scan_ticks = std::max(5, static_cast<int>(std::lround(kTicksPerSecond / scan_hz)));
  std::vector<int> divisors;
  for (int ticks = 2; ticks <= std::min(20, scan_ticks); ++ticks)
    if (scan_ticks % ticks == 0) divisors.push_back(ticks);
  if (divisors.empty()) divisors.push_back(scan_ticks);
  robot.scan_rate_hz = kTicksPerSecond / scan_ticks;
  robot.odometry.rate_hz = kTicksPerSecond / divisors[dice.below(divisors.size())];
}

void draw_lidar(Family family, Dice& dice, Scenario& robot) {
  SimulatedLidar& lidar = robot.lidar;
  const bool narrow = family == Family::narrow_view;
  // One in five sees all around.
  const double view_deg = narrow ? dice.uniform(70.0, 120.0) : std::min(360.0, dice.uniform(70.0, 432.0));
  const double least_s = family == Family::standing ? 300.0 : 30.0;
  const double most_beams = std::min(1440.0, kMostRanges / least_s / robot.scan_rate_hz);
  lidar.beams = static_cast<int>(std::lround(dice.log_uniform(90.0, most_beams)));
  lidar.angle_min_rad = -0.5 * view_deg * kRadPerDeg;
  lidar.angle_step_rad = view_deg * kRadPerDeg / (view_deg < 360.0 ? lidar.beams - 1 : lidar.beams);
  lidar.range_max_m = family == Family::short_range ? dice.uniform(3.5, 5.0)
                      : family == Family::corridor  ? dice.log_uniform(3.5, 9.0)
                                                    : dice.log_uniform(3.5, 80.0);
  lidar.range_min_m = dice.uniform(0.05, 0.15);
  lidar.sigma_range_m = dice.log_uniform(0.003, 0.04);
  lidar.sigma_range_relative = dice.uniform(0.0, 0.01);
  const double lost = dice.uniform(0.0, 1.0);
  lidar.dropout_probability = family == Family::missing_returns ? 0.3 + 0.4 * lost : 0.2 * lost * lost;
  lidar.dropout_value = static_cast<DropoutValue>(dice.below(3));
  lidar.over_range = static_cast<OverRange>(dice.below(3));
  lidar.over_range_code_m = 81.83;
  lidar.T_base_sensor = {dice.uniform(-0.2, 0.2), 0.0, 0.0};
}

/// Errors that grow with the root of the way, however often they are read: those of the motion model's form
/// are per reading.
void draw_odometry(const DrawnDrive& d, Dice& dice, SimulatedOdometry& odometry) {
  const double heading = dice.log_uniform(0.003, 0.03);      // [rad per root metre]
  const double turning = dice.log_uniform(0.005, 0.05);      // [rad per root radian]
  const double translation = dice.log_uniform(0.005, 0.03);  // [m per root metre]
  odometry.wheel_base_m = dice.uniform(0.15, 0.6);
  odometry.kappa_m = 0.5 * heading * heading * odometry.wheel_base_m * odometry.wheel_base_m;
  odometry.errors = dice.happens(0.5) ? OdometryErrors::wheels : OdometryErrors::motion_model;
  const double step_m = d.speed_mps / odometry.rate_hz, step_rad = d.turn_rate_rad_s / odometry.rate_hz;
  odometry.noise.form = MotionForm::seed;
  odometry.noise.alpha1 = turning / std::sqrt(step_rad);
  odometry.noise.alpha2 = heading / std::sqrt(2.0 * step_m);  // before and after it drives
  odometry.noise.alpha3 = translation / std::sqrt(step_m);
  odometry.noise.alpha4 = 0.0;
  odometry.scale_translation = dice.uniform(0.98, 1.02);
  odometry.scale_rotation = dice.uniform(0.98, 1.02);
  odometry.drift_rad_per_m = dice.uniform(-0.3, 0.3) * kRadPerDeg;
}

double draw_duration(const Scenario& robot, Dice& dice) {
  const double hz = robot.scan_rate_hz;
  const double most = std::min(static_cast<double>(kMostScans), kMostRanges / robot.lidar.beams);
  return std::clamp(dice.uniform(30.0, 120.0), static_cast<double>(kFewestScans) / hz,
                    std::max(static_cast<double>(kFewestScans), most) / hz);
}

void draw_start(Dice& dice, DrawnDrive& d) {
  constexpr double kFarthest = 2.5;  // standard deviations: one who says where a robot is looks at it
  d.start_sigma_m = dice.log_uniform(0.03, 0.2);
  d.start_sigma_rad = dice.log_uniform(1.0, 6.0) * kRadPerDeg;
  const auto error = [&](double sigma) { return sigma * std::clamp(dice.normal(), -kFarthest, kFarthest); };
  d.start_error.x_m = error(d.start_sigma_m);
  d.start_error.y_m = error(d.start_sigma_m);
  d.start_error.theta_rad = error(d.start_sigma_rad);
}

void draw_slips(Dice& dice, double duration_s, OdometryCorruption& c) {
  // So many that they are to be expected within the drive.
  const double per_min = std::clamp(dice.uniform(1.0, 6.0), std::min(6.0, 90.0 / duration_s), 6.0);
  const std::size_t kind = dice.below(3);  // slips, pushes, or half of each
  c.slips_per_min = kind == 0 ? per_min : kind == 1 ? 0.0 : 0.5 * per_min;
  c.hidden_per_min = kind == 1 ? per_min : kind == 0 ? 0.0 : 0.5 * per_min;
  c.most_slip_rad = dice.uniform(15.0, 40.0) * kRadPerDeg;
  c.least_slip_rad = dice.uniform(5.0, 15.0) * kRadPerDeg;
  c.most_slip_m = dice.uniform(0.3, 0.8);
  c.least_slip_m = dice.uniform(0.1, 0.3);
}

/// Slow enough to stay away from the ends, which the LiDAR must not see.
void draw_corridor(Dice& dice, DrawnDrive& d) {
  d.corridor_width_m = std::rint(100.0 * dice.uniform(1.5, 4.0)) / 100.0;
  d.corridor_start_m = dice.uniform(10.0, 12.0);
  const double longest_m = kCorridorLength_m - 10.0 - d.corridor_start_m;
  d.speed_mps = std::min(d.speed_mps, longest_m / d.duration_s);
}

void draw_trouble(Dice& dice, DrawnDrive& d) {
  switch (d.family) {
    case Family::clutter:
      d.clutter_share = dice.uniform(0.1, 0.3);
      d.people_part = dice.uniform(0.0, 1.0);
      break;
    case Family::furniture_moved:
      d.furniture_share = dice.uniform(0.05, 0.2);
      break;
    case Family::doors:
      d.doors_share = dice.uniform(0.2, 0.6);
      break;
    case Family::scale:
      d.map_scale = 1.0 + 0.01 * dice.sign();
      break;
    case Family::slips:
      draw_slips(dice, d.duration_s, d.corruption);
      break;
    case Family::late_odometry:
      d.corruption.offset_s = dice.uniform(-0.2, 0.2);
      break;
    case Family::standing:
      d.stand_s = std::min({dice.uniform(120.0, 600.0), 1000.0 / d.robot.scan_rate_hz,
                            kMostRanges / d.robot.lidar.beams / d.robot.scan_rate_hz});
      d.duration_s = d.stand_s + 20.0;
      d.corruption.gyro_drift_rad_per_s = dice.sign() * dice.log_uniform(0.001, 0.02) * kRadPerDeg;
      break;
    case Family::wrong_map:
      d.localized_on = draw_other_place(d.place, dice);
      break;
    default:
      break;
  }
}

}  // namespace

double DrawnDrive::view_rad() const {
  const double between_rad = robot.lidar.angle_step_rad * (robot.lidar.beams - 1);
  const bool all_around = robot.lidar.angle_min_rad < -kPi + 1e-9;
  return all_around ? 2.0 * kPi : between_rad;
}

DrawnDrive draw_drive(Family family, std::uint64_t seed) {
  Dice dice(family, seed);
  DrawnDrive d;
  d.family = family;
  d.seed = seed;
  d.place = d.localized_on = draw_place(family, dice);
  const Pace pace = draw_pace(family, d.place, dice);
  d.speed_mps = pace.speed_mps;
  set_rates(pace.scan_hz, dice, d.robot);
  const double fastest_turn = std::clamp(kLongestTurn_rad * d.robot.scan_rate_hz, 0.3, 2.0);
  d.turn_rate_rad_s = dice.log_uniform(0.1, fastest_turn);
  draw_lidar(family, dice, d.robot);
  d.duration_s = draw_duration(d.robot, dice);
  if (family == Family::corridor) draw_corridor(dice, d);
  draw_odometry(d, dice, d.robot.odometry);
  draw_start(dice, d);
  draw_trouble(dice, d);
  d.robot.seed = 2 * seed;  // and the next one after a kidnapping
  return d;
}

std::string place_name(std::size_t place) {
  return place == kCorridor ? "corridor" : std::string(kPlaces.at(place).name);
}

std::vector<std::pair<std::string, double>> parameters_of(const DrawnDrive& d) {
  const SimulatedLidar& lidar = d.robot.lidar;
  const SimulatedOdometry& odometry = d.robot.odometry;
  const bool wheels = odometry.errors == OdometryErrors::wheels;
  std::vector<std::pair<std::string, double>> all{
      {"duration_s", d.duration_s},
      {"scan_rate_hz", d.robot.scan_rate_hz},
      {"odometry_rate_hz", odometry.rate_hz},
      {"speed_mps", d.speed_mps},
      {"turn_rate_rad_s", d.turn_rate_rad_s},
      {"range_max_m", lidar.range_max_m},
      {"view_deg", d.view_rad() / kRadPerDeg},
      {"beams", lidar.beams},
      {"sigma_range_m", lidar.sigma_range_m},
      {"sigma_range_relative", lidar.sigma_range_relative},
      {"dropout_probability", lidar.dropout_probability},
      {"lidar_x_m", lidar.T_base_sensor.x_m},
      {"start_sigma_m", d.start_sigma_m},
      {"start_sigma_deg", d.start_sigma_rad / kRadPerDeg},
      {"odometry_scale_translation", odometry.scale_translation},
      {"odometry_scale_rotation", odometry.scale_rotation},
      {"odometry_drift_deg_per_m", odometry.drift_rad_per_m / kRadPerDeg}};
  const auto add = [&](const char* name, double value, double none) {
    if (value != none) all.emplace_back(name, value);
  };
  add("odometry_kappa_m", wheels ? odometry.kappa_m : 0.0, 0.0);
  add("odometry_wheel_base_m", wheels ? odometry.wheel_base_m : 0.0, 0.0);
  add("odometry_alpha1", wheels ? 0.0 : odometry.noise.alpha1, 0.0);
  add("odometry_alpha2", wheels ? 0.0 : odometry.noise.alpha2, 0.0);
  add("odometry_alpha3", wheels ? 0.0 : odometry.noise.alpha3, 0.0);
  add("clutter_share", d.clutter_share, 0.0);
  add("people_part", d.people_part, 0.0);
  add("furniture_share", d.furniture_share, 0.0);
  add("doors_share", d.doors_share, 0.0);
  add("map_scale", d.map_scale, 1.0);
  add("stand_s", d.stand_s, 0.0);
  add("corridor_width_m", d.corridor_width_m, 0.0);
  add("corridor_start_m", d.corridor_start_m, 0.0);
  const OdometryCorruption& c = d.corruption;
  const bool slips = c.slips_per_min > 0.0 || c.hidden_per_min > 0.0;
  add("slips_per_min", c.slips_per_min, 0.0);
  add("hidden_per_min", c.hidden_per_min, 0.0);
  add("least_slip_deg", slips ? c.least_slip_rad / kRadPerDeg : 0.0, 0.0);
  add("most_slip_deg", slips ? c.most_slip_rad / kRadPerDeg : 0.0, 0.0);
  add("least_slip_m", slips ? c.least_slip_m : 0.0, 0.0);
  add("most_slip_m", slips ? c.most_slip_m : 0.0, 0.0);
  add("odometry_late_ms", 1e3 * c.offset_s, 0.0);
  add("gyro_drift_deg_per_s", c.gyro_drift_rad_per_s / kRadPerDeg, 0.0);
  return all;
}

}  // namespace parloc
