// What PARAM lines of a CARMEN log say of its LiDARs.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "common/file/text_fields.h"
#include "common/io/carmen_angles.h"
#include "common/math/pose.h"

namespace parloc {

/// Of one LiDAR; what no line says is empty.
struct CarmenLaser {
  std::optional<double> offset_m{}, side_offset_m{}, angular_offset_rad{};
  std::optional<StatedAngle> resolution{}, field_of_view{};
  std::optional<double> max_range_m{};
  std::optional<bool> flipped{};
};

/// The two LiDARs whose lines say little: FLASER and RLASER. The names are those that CARMEN's robot and
/// laser modules write: robot_frontlaser_offset, _side_offset (to the left) [m], _angular_offset [rad], _id;
/// robot_front_laser_max [m]; laser_front_laser_resolution, _fov [degrees], _flipped, _maxrange [m]; the same
/// with rear; and laser_laser1_resolution ... laser_laser9_..., which count for the LiDAR of that id (front 1
/// and rear 2, if robot_frontlaser_id and robot_rearlaser_id do not say otherwise).
class CarmenParams {
 public:
  /// Takes "name value"; skips a name that it does not know. Throws BrokenLine for a value out of bounds.
  void take(Fields& fields);

  CarmenLaser front() const { return merged(front_, front_id_); }
  CarmenLaser rear() const { return merged(rear_, rear_id_); }
  std::size_t rear_id() const { return rear_id_; }
  /// Of any number, 1 to 9.
  CarmenLaser of_id(std::size_t id) const;

 private:
  bool take_robot(std::string_view name, Fields& fields);
  bool take_laser(std::string_view name, Fields& fields);
  CarmenLaser merged(const CarmenLaser& by_name, std::size_t id) const;

  CarmenLaser front_, rear_;
  std::array<CarmenLaser, 10> by_id_;
  std::size_t front_id_ = 1, rear_id_ = 2;
};

/// Its pose on the robot: ahead where `front`; else behind, whatever the offset's sign, and looking backwards
/// where no angle is stated.
Pose mount_of(const CarmenLaser& laser, bool front);

}  // namespace parloc
