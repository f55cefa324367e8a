// Rules that a configuration must keep, wherever it came from.
#include <cmath>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/config/config_rules.h"
#include "common/config/config_text.h"
#include "common/error.h"

namespace parloc {
namespace {

using config_text::full_name;

/// Notes the first setting that lies outside its limits.
struct LimitsCheck {
  std::optional<ConfigViolation> violation;

  template <class Number>
  void operator()(const Setting& setting, Number value, const Limits<Number>& limits) {
    if (!violation && !config_text::within(value, limits)) {
      violation = {full_name(setting), config_text::limits_message(setting, value, limits)};
    }
  }
  template <class Value, class Allowed>
  void operator()(const Setting& setting, const std::optional<Value>& value, const Allowed& allowed) {
    if (value) (*this)(setting, *value, allowed);
  }
  void operator()(const Setting&, bool) {}
  template <class Enum, std::size_t n>
  void operator()(const Setting& setting, Enum value, const std::array<Choice<Enum>, n>& choices) {
    if (!violation && config_text::choice_name(value, choices) == nullptr) {
      violation = {full_name(setting),
                   fmt::format("{} must be {}, got the number {}", full_name(setting),
                               config_text::choices_text(choices), static_cast<int>(value))};
    }
  }
};

std::optional<ConfigViolation> scan_violation(const ScanConfig& scan) {
  if (scan.min_beams > scan.max_beams) {
    return ConfigViolation{"scan.min_beams",
                           fmt::format("scan.min_beams ({}) must not exceed scan.max_beams ({})",
                                       scan.min_beams, scan.max_beams)};
  }
  if (scan.laser_min_range >= scan.laser_max_range) {
    return ConfigViolation{"scan.laser_min_range",
                           fmt::format("scan.laser_min_range ({}) must be below scan.laser_max_range ({})",
                                       scan.laser_min_range, scan.laser_max_range)};
  }
  return std::nullopt;
}

std::optional<ConfigViolation> particles_violation(const FilterConfig& c) {
  if (c.min_particles > c.most_particles()) {
    return ConfigViolation{
        "min_particles",
        fmt::format("min_particles ({}) must not exceed {} ({})", c.min_particles,
                    c.max_particles > 0 ? "max_particles" : "particles", c.most_particles())};
  }
  const double slow = c.recovery.recovery_alpha_slow, fast = c.recovery.recovery_alpha_fast;
  const bool off = slow == 0.0 && fast == 0.0;
  if (!off && !(slow > 0.0 && slow <= fast)) {
    return ConfigViolation{"recovery.recovery_alpha_slow",
                           fmt::format("recovery.recovery_alpha_slow ({}) must be above 0 and not above "
                                       "recovery.recovery_alpha_fast ({}), or both 0",
                                       slow, fast)};
  }
  return std::nullopt;
}

std::optional<ConfigViolation> lidar_violation(const FilterConfig& config, std::size_t k) {
  const LidarConfig& lidar = config.lidars[k];
  const std::string group = lidar_group(lidar);
  if (!config_text::is_lidar_name(lidar.name)) {
    return ConfigViolation{group, fmt::format("lidars: '{}' is no name of a LiDAR: {}",
                                              config_text::printable(lidar.name), config_text::kLidarNames)};
  }
  for (std::size_t j = 0; j < k; ++j) {
    if (config.lidars[j].name == lidar.name)
      return ConfigViolation{group, fmt::format("{} is there twice", group)};
  }
  LimitsCheck check;
  visit_lidar_settings(lidar, group.c_str(), check);
  if (check.violation) return check.violation;
  if (lidar.min_range && lidar.max_range && *lidar.min_range >= *lidar.max_range) {
    return ConfigViolation{group + ".min_range",
                           fmt::format("{}.min_range ({}) must be below {}.max_range ({})", group,
                                       *lidar.min_range, group, *lidar.max_range)};
  }
  if (lidar.max_beams && *lidar.max_beams < config.scan.min_beams) {
    return ConfigViolation{group + ".max_beams",
                           fmt::format("{}.max_beams ({}) must not be below scan.min_beams ({})", group,
                                       *lidar.max_beams, config.scan.min_beams)};
  }
  return std::nullopt;
}

/// SPEC 3.3: the mixture is a probability, and no single beam may rule out every particle.
std::optional<ConfigViolation> mixture_violation(const SensorConfig& sensor) {
  if (sensor.model == SensorModel::gaussian || sensor.model == SensorModel::s5)
    return std::nullopt;  // no mixture
  const double sum = sensor.z_hit + sensor.z_short + sensor.z_max + sensor.z_rand;
  if (!(std::fabs(sum - 1.0) <= 1e-6)) {
    return ConfigViolation{"sensor.z_hit",
                           fmt::format("sensor.z_hit + z_short + z_max + z_rand must be 1, got {}"
                                       " ({} + {} + {} + {})",
                                       sum, sensor.z_hit, sensor.z_short, sensor.z_max, sensor.z_rand)};
  }
  if (sensor.z_rand <= 0.0) {
    return ConfigViolation{"sensor.z_rand",
                           "sensor.z_rand must be above 0, else a single beam can rule out every particle"};
  }
  if (casts_rays(sensor.model) && sensor.z_max <= 0.0) {
    return ConfigViolation{
        "sensor.z_max", fmt::format("sensor.z_max must be above 0 with sensor.model {}, else a single beam "
                                    "without return can rule out every particle",
                                    config_text::choice_name(sensor.model, kSensorModels))};
  }
  if (sensor.model == SensorModel::class_conditional && sensor.z_short <= 0.0) {
    return ConfigViolation{"sensor.z_short",
                           "sensor.z_short must be above 0 with sensor.model class_conditional: it is the "
                           "share of beams that something off the map stops"};
  }
  return std::nullopt;
}

}  // namespace

std::optional<ConfigViolation> first_violation(const FilterConfig& config) {
  LimitsCheck check;
  visit_settings(config, check);
  if (check.violation) return check.violation;
  if (auto violation = scan_violation(config.scan)) return violation;
  if (auto violation = particles_violation(config)) return violation;
  for (std::size_t k = 0; k < config.lidars.size(); ++k) {
    if (auto violation = lidar_violation(config, k)) return violation;
  }
  return mixture_violation(config.sensor);
}

void validate(const FilterConfig& config) {
  if (const auto violation = first_violation(config)) throw Error(ErrorKind::config, violation->message);
}

}  // namespace parloc
