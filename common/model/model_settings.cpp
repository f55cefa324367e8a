#include "common/model/model_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/error.h"

namespace parloc {
namespace {

const std::vector<Choice<MotionForm>> kMotionForms{
    {"seed", MotionForm::seed}, {"thrun", MotionForm::thrun}, {"omni", MotionForm::omni}};
const std::vector<Choice<ZeroPolicy>> kZeroPolicies{{"invalid", ZeroPolicy::invalid},
                                                    {"miss", ZeroPolicy::miss}};
const std::vector<Choice<StampAt>> kStampAts{
    {"first", StampAt::first}, {"middle", StampAt::middle}, {"last", StampAt::last}};
const std::vector<Choice<FieldLookup>> kFieldLookups{{"nearest", FieldLookup::nearest},
                                                     {"bilinear", FieldLookup::bilinear}};

constexpr const char* kLidars = "lidars";
constexpr std::size_t kMostMasked = 32;

std::vector<Setting> settings_of(LidarConfig& lidar) {
  Settings s;
  s.group((std::string(kLidars) + "." + lidar.name).c_str(), "");
  s.add("x", "Place on the robot, ahead [m]; what is left out here is as the log says", lidar.x, {-100, 100});
  s.add("y", "... to the left [m]", lidar.y, {-100, 100});
  s.add("yaw", "... and where its angle 0 looks, counter-clockwise [rad]", lidar.yaw, {-6.3, 6.3});
  s.add("upside_down", "Mirrored about its own x axis: its angles run clockwise", lidar.upside_down);
  s.add("flipped", "The same, in CARMEN's word", lidar.flipped);
  s.add("angle_min", "Where its first beam looks, over what the log says [rad]", lidar.angle_min,
        {-6.3, 6.3});
  s.add("angle_step", "... and from beam to beam, below 0 clockwise [rad]", lidar.angle_step, {-3.2, 3.2});
  s.add("mask", "Beams that see the robot itself, as it is mounted: not used [rad]", lidar.mask, {-6.3, 6.3},
        kMostMasked);
  s.add("min_range", "Shortest range [m]", lidar.min_range, {0, 1000});
  s.add("max_range", "Longest range [m]", lidar.max_range, {0, 1000, true});
  s.add("zero_policy", "As scan.zero_policy", lidar.zero_policy, kZeroPolicies);
  s.add("max_beams", "As scan.max_beams", lidar.max_beams, {1, 4096});
  s.add("scan_time", "As scan.scan_time, but over what the log says [s]", lidar.scan_time, {0, 1});
  s.add("stamp_at", "As scan.stamp_at", lidar.stamp_at, kStampAts);
  return std::move(s.all);
}

/// A LiDAR that says everything.
LidarConfig example_lidar() {
  return {.name = "front",
          .x = 0.0,
          .y = 0.0,
          .yaw = 0.0,
          .upside_down = false,
          .angle_min = -1.5708,
          .angle_step = 0.00873,
          .mask = {{2.5, -2.5}},
          .min_range = 0.1,
          .max_range = 40.0,
          .max_beams = 100,
          .zero_policy = ZeroPolicy::invalid,
          .scan_time = 0.0,
          .stamp_at = StampAt::first};
}

LidarConfig& lidar_named(const std::string& name, std::vector<LidarConfig>& lidars) {
  for (LidarConfig& lidar : lidars)
    if (lidar.name == name) return lidar;
  lidars.emplace_back().name = name;
  return lidars.back();
}

std::optional<Violation> broken_rule(const LidarConfig& lidar, const ScanConfig& scan) {
  const std::string group = std::string(kLidars) + "." + lidar.name;
  if (!is_setting_name(lidar.name))
    return Violation{
        group, fmt::format("lidars: '{}' is no name of a LiDAR: {}", printable(lidar.name), kExpectedName)};
  LidarConfig copy = lidar;
  for (const Setting& setting : settings_of(copy))
    if (const std::string message = limits_message(setting); !message.empty())
      return Violation{setting.name(), message};
  if (lidar.upside_down && lidar.flipped && *lidar.upside_down != *lidar.flipped)
    return Violation{
        group + ".flipped",
        fmt::format("{0}.flipped is another word for {0}.upside_down: they must not differ", group)};
  if (lidar.angle_step && *lidar.angle_step == 0.0)
    return Violation{group + ".angle_step", fmt::format("{}.angle_step must not be 0", group)};
  if (lidar.min_range && lidar.max_range && *lidar.min_range >= *lidar.max_range)
    return Violation{group + ".min_range", fmt::format("{}.min_range ({}) must be below {}.max_range ({})",
                                                       group, *lidar.min_range, group, *lidar.max_range)};
  if (lidar.max_beams && *lidar.max_beams < scan.min_beams)
    return Violation{group + ".max_beams",
                     fmt::format("{}.max_beams ({}) must not be below scan.min_beams ({})", group,
                                 *lidar.max_beams, scan.min_beams)};
  return std::nullopt;
}

}  // namespace

void add_settings(Settings& s, MotionConfig& motion) {
  s.group("motion", "How the robot moves: odometry motion model.");
  s.add("form", "seed: sigma linear in the motion; thrun: variance quadratic (as AMCL); omni: sideways too",
        motion.form, kMotionForms);
  s.add("alpha1", "Rotation noise from rotation [1]", motion.alpha1, {0, 100});
  s.add("alpha2", "Rotation noise from translation [rad/m]", motion.alpha2, {0, 100});
  s.add("alpha3", "Translation noise from translation [1]", motion.alpha3, {0, 100});
  s.add("alpha4", "Translation noise from rotation [m/rad]", motion.alpha4, {0, 100});
  s.add("alpha5", "omni: sideways noise from translation [1]", motion.alpha5, {0, 100});
  s.add("sigma_rot_min_rad", "Noise floor of each rotation, only while the robot moves [rad]",
        motion.sigma_rot_min_rad, {0, 10});
  s.add("sigma_trans_min_m", "Noise floor of the translation, only while the robot moves [m]",
        motion.sigma_trans_min_m, {0, 10});
  s.add("sigma_rot_per_s", "Rotation noise besides, standing too [rad/sqrt(s)]", motion.sigma_rot_per_s,
        {0, 10});
  s.add("sigma_trans_per_s", "Translation noise besides, standing too [m/sqrt(s)]", motion.sigma_trans_per_s,
        {0, 10});
  s.add("slip_share", "Share of the particles that move as if the wheels slipped: a heavy tail",
        motion.slip_share, {0, 1});
  s.add("slip_sigma_m", "Noise of a slip [m]", motion.slip_sigma_m, {0, 10});
  s.add("slip_sigma_rad", "Noise of a slip [rad]", motion.slip_sigma_rad, {0, 10});
  s.add("min_translation_m", "A shorter step is a turn in place [m]", motion.min_translation_m, {0, 10});
  s.add("symmetric", "Driving backwards is not a turn by pi", motion.symmetric);
  s.add("max_speed_mps", "A faster step is a jump of the odometry, and no motion [m/s]", motion.max_speed_mps,
        {0, 1000, true});
  s.add("max_acceleration_mps2", "Likewise one that gets faster than this [m/s^2]",
        motion.max_acceleration_mps2, {0, 1000, true});
  s.add("max_turn_rate_rad_s", "Likewise one that turns faster [rad/s]", motion.max_turn_rate_rad_s,
        {0, 1000, true});
  s.add("max_jump_m", "Likewise a longer one, where stamps stand still [m]", motion.max_jump_m,
        {0, 1000, true});
  s.add("odometry_delay_s", "The odometry comes so much later than the scans [s]", motion.odometry_delay_s,
        {-2, 2});
  s.add("odometry_scale_drive", "Its metres times this are true ones (parloc learn)",
        motion.odometry_scale_drive, {0.1, 10});
  s.add("odometry_scale_turn", "Its turns times this are true ones", motion.odometry_scale_turn, {0.1, 10});
  s.add("odometry_scale_side", "omni: likewise to the side", motion.odometry_scale_side, {0.1, 10});
}

void add_settings(Settings& s, ScanConfig& scan) {
  s.group("scan", "Which beams of a scan are used, and what their values mean.");
  s.add("max_beams", "Beams used of a scan, evenly spaced in angle", scan.max_beams, {1, 4096});
  s.add("min_beams", "Fewer usable beams: prediction only", scan.min_beams, {1, 4096});
  s.add("laser_min_range", "Shortest range, where the log gives none [m]", scan.laser_min_range, {0, 1000});
  s.add("laser_max_range", "Longest range, where the log gives none [m]", scan.laser_max_range,
        {0, 1000, true});
  s.add("zero_policy", "What a range of exactly 0 means: a broken beam, or no return", scan.zero_policy,
        kZeroPolicies);
  s.add("scan_time", "From a scan's first beam to its last, where the log gives none [s]", scan.scan_time,
        {0, 1});
  s.add("stamp_at", "The beam that a scan's stamp is the time of", scan.stamp_at, kStampAts);
  s.add("check_stamps", "Refuse a LiDAR's scan that came twice, or is 2 s older than its newest",
        scan.check_stamps);
}

void add_settings(Settings& s, SensorConfig& sensor) {
  s.group("sensor", "How well a scan fits the map at a pose. Each model uses the keys it knows.");
  s.add("model", "The first four cast rays, the others look up end points", sensor.model, kSensorModels);
  s.add("sigma_hit", "Standard deviation of a range, or of a wall's place (field) [m]", sensor.sigma_hit,
        {0.001, 10});
  s.add("z_hit", "Share of beams that end at the map's walls; the four shares sum to 1", sensor.z_hit,
        {0, 1});
  s.add("z_short", "Share of beams that something else stops (beam, class_conditional)", sensor.z_short,
        {0, 1});
  s.add("z_max", "Share of beams that never return (beam, class_conditional)", sensor.z_max, {0, 1});
  s.add("z_rand", "Share of beams that say nothing", sensor.z_rand, {0, 1});
  s.add("lambda_short", "Decay of the short beams (beam, class_conditional) [1/m]", sensor.lambda_short,
        {0, 100, true});
  s.add("laser_likelihood_max_dist", "Cap of the distance to a wall (field) [m]",
        sensor.laser_likelihood_max_dist, {0.01, 100});
  s.add("effective_beams", "Independent beams that a scan is worth, however many it has",
        sensor.effective_beams, {0, 4096, true});
  s.add("tempering", "Exponent of a scan's likelihood; 0: effective_beams / beams", sensor.tempering, {0, 1});
  s.add("s5_epsilon", "Weight of a beam beyond the maximum, measured and expected (s5)", sensor.s5_epsilon,
        {1e-30, 1});
  s.add("do_beamskip", "Skip beams that few particles agree with (likelihood_field_prob)",
        sensor.do_beamskip);
  s.add("beam_skip_distance", "A particle agrees with a beam that ends this near a wall [m]",
        sensor.beam_skip_distance, {0.001, 100});
  s.add("beam_skip_threshold", "Share of the particles that must agree with a beam",
        sensor.beam_skip_threshold, {0, 1});
  s.add("beam_skip_error_threshold", "All beams count if this share of them would be skipped",
        sensor.beam_skip_error_threshold, {0, 1});
  s.add("beam_skip_spread", "Skip only while the particles' standard deviation is less [m]",
        sensor.beam_skip_spread, {0, 1000});
  s.add("lookup", "How the distance field is read (field)", sensor.lookup, kFieldLookups);
  s.add("caster", "skip and dda are exact and equal; fixed_step is the 2012 paper's", sensor.caster,
        kRayCasters);
  s.add("fixed_step_cells", "Step of the fixed_step caster [cells]", sensor.fixed_step_cells, {0.01, 10});
  s.add("unknown_blocks", "A ray ends at an unknown cell", sensor.unknown_blocks);
}

NamedSettings named_settings(std::vector<LidarConfig>& lidars) {
  static LidarConfig example = example_lidar();
  NamedSettings named;
  named.a_thing = "a LiDAR";
  named.group = {
      kLidars,
      "What the log does not say of a LiDAR, or says wrongly: an entry for each, by its name in the log."};
  named.names = [&lidars] {
    std::vector<std::string> names;
    for (const LidarConfig& lidar : lidars) names.push_back(lidar.name);
    return names;
  };
  named.of = [&lidars](const std::string& name) { return settings_of(lidar_named(name, lidars)); };
  named.example = settings_of(example);
  named.example_name = example.name;
  return named;
}

std::optional<Violation> broken_rule(const ScanConfig& scan) {
  if (scan.min_beams > scan.max_beams) {
    return Violation{"scan.min_beams", fmt::format("scan.min_beams ({}) must not exceed scan.max_beams ({})",
                                                   scan.min_beams, scan.max_beams)};
  }
  if (scan.laser_min_range >= scan.laser_max_range) {
    return Violation{"scan.laser_min_range",
                     fmt::format("scan.laser_min_range ({}) must be below scan.laser_max_range ({})",
                                 scan.laser_min_range, scan.laser_max_range)};
  }
  return std::nullopt;
}

std::optional<Violation> broken_rule(const SensorConfig& sensor) {
  if (sensor.model == SensorModel::gaussian || sensor.model == SensorModel::s5)
    return std::nullopt;  // no mixture
  const double sum = sensor.z_hit + sensor.z_short + sensor.z_max + sensor.z_rand;
  if (!(std::fabs(sum - 1.0) <= 1e-6)) {
    return Violation{"sensor.z_hit",
                     fmt::format("sensor.z_hit + z_short + z_max + z_rand must be 1, got {}"
                                 " ({} + {} + {} + {})",
                                 sum, sensor.z_hit, sensor.z_short, sensor.z_max, sensor.z_rand)};
  }
  if (sensor.z_rand <= 0.0) {
    return Violation{"sensor.z_rand",
                     "sensor.z_rand must be above 0, else a single beam can rule out every particle"};
  }
  if (casts_rays(sensor.model) && sensor.z_max <= 0.0) {
    return Violation{"sensor.z_max",
                     fmt::format("sensor.z_max must be above 0 with sensor.model {}, else a single beam "
                                 "without return can rule out every particle",
                                 name_of(sensor.model, kSensorModels))};
  }
  if (sensor.model == SensorModel::class_conditional && sensor.z_short <= 0.0) {
    return Violation{"sensor.z_short",
                     "sensor.z_short must be above 0 with sensor.model class_conditional: it is the "
                     "share of beams that something off the map stops"};
  }
  return std::nullopt;
}

std::optional<Violation> broken_rule(const std::vector<LidarConfig>& lidars, const ScanConfig& scan) {
  for (auto lidar = lidars.begin(); lidar != lidars.end(); ++lidar) {
    const auto same = [&](const LidarConfig& other) { return other.name == lidar->name; };
    if (is_setting_name(lidar->name) && std::any_of(lidars.begin(), lidar, same))
      return Violation{std::string(kLidars) + "." + lidar->name,
                       fmt::format("{}.{} is there twice", kLidars, lidar->name)};
    if (auto violation = broken_rule(*lidar, scan)) return violation;
  }
  return std::nullopt;
}

}  // namespace parloc
