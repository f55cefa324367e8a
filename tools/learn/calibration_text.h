// A calibration for people, for programs and for a configuration.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/calibrate/calibration.h"
#include "common/model/motion_config.h"

namespace parloc::tools {

/// What was asked for; all is estimated in any case.
struct CalibrationParts {
  bool mount = false, odometry = false, delay = false;
  bool any() const { return mount || odometry || delay; }
};

/// "mount,odometry,delay" or some of them. Throws Error{usage} for another word, naming those that there are.
CalibrationParts calibration_parts(const std::string& what);

/// A number of the calibration, with what is stated of it now.
struct CalibrationRow {
  std::string name, unit, key;  ///< For people; of the table; of JSON and configuration.
  Estimate1 found;
  double stated = 0.0;
  double shown = 1.0;  ///< Factor from the number to the table's unit.
};
std::vector<CalibrationRow> mount_rows(const LidarCalibration& lidar);
std::vector<CalibrationRow> odometry_rows(const LogCalibration& found, const CalibrationParts& parts,
                                          const MotionConfig& stated);

/// Value, standard deviation, what is stated and the difference; what the drive leaves open has no value.
std::string calibration_table(const LogCalibration& found, const CalibrationParts& parts,
                              const MotionConfig& stated);
/// The settings to paste, with standard deviations as remarks; nothing that is not determined.
std::string calibration_settings(const LogCalibration& found, const CalibrationParts& parts,
                                 const MotionConfig& stated, const std::string& typed);
nlohmann::ordered_json calibration_json(const LogCalibration& found, const CalibrationParts& parts,
                                        const MotionConfig& stated);

}  // namespace parloc::tools
