// The tables of settings of the models and LiDARs, and the rules between them.
#pragma once

#include <optional>
#include <vector>

#include "common/model/motion_config.h"
#include "common/model/scan_config.h"
#include "common/model/sensor_config.h"
#include "common/settings/setting.h"

namespace parloc {

inline const std::vector<Choice<SensorModel>> kSensorModels{
    {"gaussian", SensorModel::gaussian},
    {"s5", SensorModel::s5},
    {"beam", SensorModel::beam},
    {"class_conditional", SensorModel::class_conditional},
    {"likelihood_field", SensorModel::likelihood_field},
    {"likelihood_field_prob", SensorModel::likelihood_field_prob}};
inline const std::vector<Choice<RayCaster>> kRayCasters{
    {"skip", RayCaster::skip}, {"dda", RayCaster::dda}, {"fixed_step", RayCaster::fixed_step}};

/// Each adds a group, whose values lie in the struct; that outlives the table.
void add_settings(Settings& s, MotionConfig& motion);
void add_settings(Settings& s, ScanConfig& scan);
void add_settings(Settings& s, SensorConfig& sensor);
/// An entry for each LiDAR, in no order; entries can be made.
NamedSettings named_settings(std::vector<LidarConfig>& lidars);

/// What goes beyond the limits of single settings.
std::optional<Violation> broken_rule(const ScanConfig& scan);
/// SPEC 3.3: the mixture is a probability, and no single beam may rule out every particle.
std::optional<Violation> broken_rule(const SensorConfig& sensor);
/// Limits of each LiDAR's settings too.
std::optional<Violation> broken_rule(const std::vector<LidarConfig>& lidars, const ScanConfig& scan);

}  // namespace parloc
