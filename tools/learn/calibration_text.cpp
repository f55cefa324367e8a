#include "tools/learn/calibration_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/error.h"
#include "common/math/angle_units.h"
#include "common/math/portable64.h"

namespace parloc::tools {
namespace {

/// A difference is marked beyond so many standard deviations.
constexpr double kClearly = 3.0;

double difference_of(const CalibrationRow& row) {
  const double difference = row.found.value - row.stated;
  return row.key == "yaw" ? wrap64(difference) : difference;
}

std::string row_text(const CalibrationRow& row) {
  const std::string head = fmt::format("  {:<16} {:<7}", row.name, row.unit);
  const double stated = row.shown * row.stated;
  if (!row.found.determined) return fmt::format("{} {:>10} {:>10} {:>10.4f}\n", head, "?", "", stated);
  const double difference = difference_of(row);
  return fmt::format("{} {:>10.4f} {:>10.4f} {:>10.4f} {:>+11.4f}{}\n", head, row.shown * row.found.value,
                     row.shown * row.found.sigma, stated, row.shown * difference,
                     std::fabs(difference) > kClearly * row.found.sigma ? " *" : "");
}

const char* yes_or_no(bool is) {
  return is ? "yes" : "no";
}

std::string side_text(const LidarCalibration& lidar) {
  return fmt::format("  {:<16} {:<7} {:>10} {:>10} {:>10}{}\n", "upside down", "",
                     lidar.fit.side_known ? yes_or_no(lidar.fit.upside_down) : "?", "",
                     yes_or_no(lidar.stated.upside_down),
                     lidar.fit.upside_down != lidar.stated.upside_down ? "           * " : "");
}

/// Names of what the drive does not say.
std::vector<std::string> open_names(const LogCalibration& found, const CalibrationParts& parts,
                                    const MotionConfig& stated) {
  std::vector<std::string> names;
  for (const LidarCalibration& lidar : found.lidars) {
    if (!parts.mount) continue;
    for (const CalibrationRow& row : mount_rows(lidar))
      if (!row.found.determined) names.push_back(lidar.name + " " + row.name);
    if (!lidar.fit.side_known) names.push_back(lidar.name + " upside down");
  }
  for (const CalibrationRow& row : odometry_rows(found, parts, stated))
    if (!row.found.determined) names.push_back(row.name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

nlohmann::ordered_json row_json(const CalibrationRow& row) {
  nlohmann::ordered_json j;
  j["determined"] = row.found.determined;
  j["value"] = row.found.determined ? nlohmann::ordered_json(row.found.value) : nlohmann::ordered_json();
  j["sigma"] = row.found.sigma;
  j["stated"] = row.stated;
  return j;
}

/// The wheels' drift has no setting.
bool has_setting(const CalibrationRow& row) {
  return row.found.determined && row.key.rfind("odometry_", 0) == 0;
}

}  // namespace

CalibrationParts calibration_parts(const std::string& what) {
  CalibrationParts parts;
  std::istringstream words(what);
  for (std::string word; std::getline(words, word, ',');) {
    if (word == "mount") {
      parts.mount = true;
    } else if (word == "odometry") {
      parts.odometry = true;
    } else if (word == "delay") {
      parts.delay = true;
    } else {
      throw Error(
          ErrorKind::usage,
          fmt::format("--what: expected sensor, or some of mount,odometry,delay, got '{}'", printable(word)));
    }
  }
  return parts;
}

std::vector<CalibrationRow> mount_rows(const LidarCalibration& lidar) {
  const MountFit& f = lidar.fit;
  const Pose& stated = lidar.stated.T_base_sensor;
  return {{"x, ahead", "m", "x", f[Unknown::x], stated.x_m, 1.0},
          {"y, to the left", "m", "y", f[Unknown::y], stated.y_m, 1.0},
          {"yaw", "degrees", "yaw", f[Unknown::yaw], stated.theta_rad, kDegPerRad}};
}

std::vector<CalibrationRow> odometry_rows(const LogCalibration& found, const CalibrationParts& parts,
                                          const MotionConfig& stated) {
  std::vector<CalibrationRow> rows;
  if (parts.odometry) {
    rows.push_back({"scale of drive", "", "odometry_scale_drive", found[Unknown::drive],
                    stated.odometry_scale_drive, 1.0});
    if (found.omni)
      rows.push_back({"scale sideways", "", "odometry_scale_side", found[Unknown::side],
                      stated.odometry_scale_side, 1.0});
    rows.push_back(
        {"scale of turn", "", "odometry_scale_turn", found[Unknown::turn], stated.odometry_scale_turn, 1.0});
    rows.push_back({"turns besides", "deg/m", "drift_rad_per_m", found[Unknown::drift], 0.0, kDegPerRad});
  }
  if (parts.delay)
    rows.push_back({"delay", "s", "odometry_delay_s", found[Unknown::delay], stated.odometry_delay_s, 1.0});
  return rows;
}

std::string calibration_table(const LogCalibration& found, const CalibrationParts& parts,
                              const MotionConfig& stated) {
  std::string text = fmt::format(
      "{:.1f} m driven and {:.0f} degrees turned, by the odometry\n"
      "  {:<16} {:<7} {:>10} {:>10} {:>10} {:>11}\n",
      found.driven_m, found.turned_rad * kDegPerRad, "", "", "value", "+-", "stated", "difference");
  for (const LidarCalibration& lidar : found.lidars) {
    text += fmt::format("{}: {} motions compared, {} scans{}\n", lidar.name, lidar.fit.motions, lidar.scans,
                        lidar.fit.unlike > 0
                            ? fmt::format("; {} motions do not fit and hardly count", lidar.fit.unlike)
                            : "");
    if (!parts.mount) continue;
    for (const CalibrationRow& row : mount_rows(lidar)) text += row_text(row);
    text += side_text(lidar);
  }
  const std::vector<CalibrationRow> rows = odometry_rows(found, parts, stated);
  if (!rows.empty()) text += fmt::format("odometry{}\n", found.omni ? ": drives sideways, too" : "");
  for (const CalibrationRow& row : rows) text += row_text(row);
  const std::vector<std::string> open = open_names(found, parts, stated);
  if (!open.empty()) text += fmt::format("not determined by this drive: {}\n", joined(open));
  return text;
}

std::string calibration_settings(const LogCalibration& found, const CalibrationParts& parts,
                                 const MotionConfig& stated, const std::string& typed) {
  std::string text = fmt::format("# learned by: {}\n", typed), lidars, motion;
  for (const LidarCalibration& lidar : found.lidars) {
    std::string entry;
    for (const CalibrationRow& row : mount_rows(lidar))
      if (row.found.determined)
        entry += fmt::format("    {}: {:.4f}   # +- {:.4f}\n", row.key, row.found.value, row.found.sigma);
    if (lidar.fit.side_known)
      entry += fmt::format("    upside_down: {}\n", lidar.fit.upside_down ? "true" : "false");
    if (parts.mount && !entry.empty()) lidars += fmt::format("  {}:\n{}", lidar.name, entry);
  }
  for (const CalibrationRow& row : odometry_rows(found, parts, stated))
    if (has_setting(row))
      motion += fmt::format("  {}: {:.4f}   # +- {:.4f}\n", row.key, row.found.value, row.found.sigma);
  if (!lidars.empty()) text += "lidars:\n" + lidars;
  if (!motion.empty()) text += "motion:\n" + std::string(found.omni ? "  form: omni\n" : "") + motion;
  const std::vector<std::string> open = open_names(found, parts, stated);
  if (!open.empty()) text += fmt::format("# not determined by this drive: {}\n", joined(open));
  return text;
}

nlohmann::ordered_json calibration_json(const LogCalibration& found, const CalibrationParts& parts,
                                        const MotionConfig& stated) {
  nlohmann::ordered_json j;
  j["driven_m"] = found.driven_m;
  j["turned_rad"] = found.turned_rad;
  j["omni"] = found.omni;
  j["lidars"] = nlohmann::ordered_json::array();
  for (const LidarCalibration& lidar : found.lidars) {
    nlohmann::ordered_json one{{"name", lidar.name},
                               {"scans", lidar.scans},
                               {"motions", lidar.fit.motions},
                               {"unlike", lidar.fit.unlike}};
    if (parts.mount) {
      for (const CalibrationRow& row : mount_rows(lidar)) one[row.key] = row_json(row);
      one["upside_down"] = {{"determined", lidar.fit.side_known},
                            {"value", lidar.fit.upside_down},
                            {"stated", lidar.stated.upside_down}};
    }
    j["lidars"].push_back(one);
  }
  for (const CalibrationRow& row : odometry_rows(found, parts, stated))
    j["odometry"][row.key] = row_json(row);
  j["not_determined"] = open_names(found, parts, stated);
  return j;
}

}  // namespace parloc::tools
