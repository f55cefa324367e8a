#include "common/calibrate/mount_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/calibrate/calibration.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kClearly = 4.0;  // standard deviations

bool differs(const Estimate1& found, double difference, double least) {
  return found.determined && std::fabs(difference) > std::max(least, kClearly * found.sigma);
}

std::string text_of(const LidarCalibration& lidar) {
  const MountFit& fit = lidar.fit;
  const Pose& stated = lidar.stated.T_base_sensor;
  std::string says, settings;
  const auto add = [&](const std::string& what, const char* setting) {
    says += (says.empty() ? "" : ", ") + what;
    settings += std::string(settings.empty() ? "" : ", ") + setting;
  };
  if (fit.side_known && fit.upside_down != lidar.stated.upside_down)
    add(fit.upside_down ? "upside down" : "not upside down", "upside_down");
  const double turned_rad = wrap64(fit[Unknown::yaw].value - stated.theta_rad);
  if (differs(fit[Unknown::yaw], turned_rad, MountCheck::kLeastTurn_rad))
    add(fmt::format("turned by {:.0f} +- {:.0f} degrees", turned_rad * 180.0 / kPi,
                    std::ceil(fit[Unknown::yaw].sigma * 180.0 / kPi)),
        "yaw");
  const double dx_m = fit[Unknown::x].value - stated.x_m, dy_m = fit[Unknown::y].value - stated.y_m;
  if (differs(fit[Unknown::x], dx_m, MountCheck::kLeastWay_m) ||
      differs(fit[Unknown::y], dy_m, MountCheck::kLeastWay_m))
    add(fmt::format("at ({:.2f} m, {:.2f} m)", fit[Unknown::x].value, fit[Unknown::y].value), "x, y");
  if (says.empty()) return {};
  return fmt::format(
      "{0}: the scans move against the odometry as if the LiDAR were {1}, other than stated: lidars.{0}.{2} "
      "say where it is (parloc learn --what mount)",
      lidar.name, says, settings);
}

}  // namespace

MountCheck::MountCheck(std::vector<LidarConfig> lidars, const ScanConfig& scan)
    : lidars_(std::move(lidars)), scan_(scan), motions_(std::make_unique<ScanMotions>(scan_, lidars_)) {}

MountCheck::~MountCheck() = default;

bool MountCheck::enough() const {
  if (motions_->scans() >= kMostScans) return true;
  const auto has_enough = [](const LidarMotions& lidar) { return lidar.motions.size() >= kEnoughMotions; };
  const std::vector<LidarMotions>& lidars = motions_->lidars();
  return !lidars.empty() && std::all_of(lidars.begin(), lidars.end(), has_enough);
}

void MountCheck::add(const LogRecord& record) {
  if (!enough()) motions_->add(record);
}

std::vector<LogNote> MountCheck::verdict() {
  std::vector<LogNote> notes;
  for (const LidarCalibration& lidar : calibrate(*motions_, false).lidars)
    if (std::string text = text_of(lidar); !text.empty())
      notes.push_back({LogNote::About::mount, lidar.name, std::move(text)});
  return notes;
}

}  // namespace parloc
