#include "common/io/carmen_params.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/math/angle_units.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kMaxOffsetM = 1e8;
constexpr double kMaxTurnRad = 4.0 * kPi;
constexpr double kMaxRangeM = 1e6;

bool take_prefix(std::string_view& name, std::string_view prefix) {
  if (name.substr(0, prefix.size()) != prefix) return false;
  name.remove_prefix(prefix.size());
  return true;
}

double above_zero(Fields& fields, const char* what, double most) {
  const Fields before = fields;
  const double value = fields.bounded(what, most);
  if (!(value > 0.0)) Fields(before).fail(what);
  return value;
}

// In degrees. CARMEN's laser module refuses half a turn in radians for the same reason: it is a mistake.
StatedAngle degrees(Fields& fields, const char* what, double most_deg, double least_deg) {
  const std::string_view text = Fields(fields).text();
  const Fields before = fields;
  const double value_deg = above_zero(fields, what, most_deg);
  if (value_deg < least_deg) Fields(before).fail(what);
  return {kPi * (value_deg / 180.0), half_last_place(text) * kRadPerDeg};
}

bool on_or_off(Fields& fields) {
  const Fields before = fields;
  std::string word(fields.text().substr(0, 6));
  for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char* yes : {"1", "on", "true", "yes"})
    if (word == yes) return true;
  for (const char* no : {"0", "off", "false", "no"})
    if (word == no) return false;
  Fields(before).fail("on or off (1 or 0)");
}

std::size_t laser_id(Fields& fields) {
  const Fields before = fields;
  const auto id = fields.number<std::size_t>("the number of a LiDAR, 0 to 9");
  if (id > 9) Fields(before).fail("the number of a LiDAR, 0 to 9");
  return id;
}

bool take_mount(std::string_view key, Fields& fields, CarmenLaser& laser) {
  if (key == "offset")
    laser.offset_m = fields.bounded("an offset in metres", kMaxOffsetM);
  else if (key == "side_offset")
    laser.side_offset_m = fields.bounded("an offset in metres", kMaxOffsetM);
  else if (key == "angular_offset")
    laser.angular_offset_rad = fields.bounded("an angle in radians within two turns", kMaxTurnRad);
  else
    return false;
  return true;
}

template <class Value>
void fill(std::optional<Value>& value, const std::optional<Value>& otherwise) {
  if (!value) value = otherwise;
}

}  // namespace

bool CarmenParams::take_robot(std::string_view name, Fields& fields) {
  for (const bool front : {true, false}) {
    std::string_view key = name;
    CarmenLaser& laser = front ? front_ : rear_;
    if (take_prefix(key, front ? "frontlaser_" : "rearlaser_")) {
      if (key != "id") return take_mount(key, fields, laser);
      (front ? front_id_ : rear_id_) = laser_id(fields);
      return true;
    }
    if (key == (front ? "front_laser_max" : "rear_laser_max")) {
      laser.max_range_m = above_zero(fields, "a range in metres", kMaxRangeM);
      return true;
    }
  }
  return false;
}

bool CarmenParams::take_laser(std::string_view name, Fields& fields) {
  CarmenLaser* laser = nullptr;
  if (take_prefix(name, "front_laser_")) {
    laser = &front_;
  } else if (take_prefix(name, "rear_laser_")) {
    laser = &rear_;
  } else if (name.size() > 7 && name[5] >= '1' && name[5] <= '9' && name[6] == '_' &&
             take_prefix(name, "laser")) {
    laser = &by_id_[static_cast<std::size_t>(name[0] - '0')];
    name.remove_prefix(2);
  } else {
    return false;
  }
  if (name == "resolution")
    laser->resolution = degrees(fields, "an angle step in degrees, above 0 and at most 90", 90.0, 0.0);
  else if (name == "fov")
    laser->field_of_view = degrees(fields, "a field of view in degrees, 4 to 360", 360.0, 4.0);
  else if (name == "flipped")
    laser->flipped = on_or_off(fields);
  else if (name == "maxrange" || name == "max_range")
    laser->max_range_m = above_zero(fields, "a range in metres", kMaxRangeM);
  else
    return false;
  return true;
}

void CarmenParams::take(Fields& fields) {
  std::string_view name = fields.text();
  if (take_prefix(name, "robot_"))
    take_robot(name, fields);
  else if (take_prefix(name, "laser_"))
    take_laser(name, fields);
}

CarmenLaser CarmenParams::merged(const CarmenLaser& by_name, std::size_t id) const {
  CarmenLaser laser = by_name;
  const CarmenLaser& other = by_id_[id];
  fill(laser.resolution, other.resolution);
  fill(laser.field_of_view, other.field_of_view);
  fill(laser.max_range_m, other.max_range_m);
  fill(laser.flipped, other.flipped);
  return laser;
}

CarmenLaser CarmenParams::of_id(std::size_t id) const {
  return id == front_id_ ? front() : id == rear_id_ ? rear() : by_id_[id];
}

Pose mount_of(const CarmenLaser& laser, bool front) {
  Pose mount;
  if (laser.offset_m) mount.x_m = front ? *laser.offset_m : -std::fabs(*laser.offset_m);
  mount.y_m = laser.side_offset_m.value_or(0.0);
  mount.theta_rad = front ? 0.0 : -kPi;
  if (laser.angular_offset_rad) mount.theta_rad = wrap64(*laser.angular_offset_rad);
  return mount;
}

}  // namespace parloc
