#include "tools/slam/log_oddities.h"
#include "common/config/config.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <system_error>

#include "common/inputs/open_log.h"

namespace parloc::tools::slam {
namespace {

bool same(const Pose& a, const Pose& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.theta_rad == b.theta_rad;
}

}  // namespace

bool odometry_stands_still(LogReader& log) {
  LogRecord record;
  std::optional<Pose> first;
  std::size_t scans = 0;
  while (log.next(record)) {
    if (!first) first = record.odometry;
    if (!same(record.odometry, *first)) return false;
    scans += record.kind == RecordKind::scan ? 1 : 0;
  }
  return scans > 1;
}

bool choose_odometry(const std::string& log_path, Config& config) {
  std::error_code none;
  if (config.slam.odometry == SlamOdometry::scans || !std::filesystem::is_regular_file(log_path, none))
    return false;
  if (!odometry_stands_still(*open_log(log_path, log_choice(config)))) return false;
  config.slam.odometry = SlamOdometry::scans;
  return true;
}

}  // namespace parloc::tools::slam
