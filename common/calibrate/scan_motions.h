// How a LiDAR moved by its own scans, from one place of a drive to the next: what a calibration compares with
// the odometry.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "common/calibrate/line_scan.h"
#include "common/calibrate/odometry_path.h"
#include "common/io/log.h"
#include "common/math/pose.h"
#include "common/model/scan_config.h"

namespace parloc {

/// Where a LiDAR sits on the robot.
struct Mount {
  Pose T_base_sensor;
  bool upside_down = false;
};

/// A step in the sensor's frame of a LiDAR that is upside down, told by scans that are its mirror image; and
/// back.
Pose mirrored(const Pose& step);

struct KeyScan {
  double time_s = 0.0;  ///< As OdometryPath has it.
  Scan scan;
};

/// From one key scan to the next.
struct ScanMotion {
  std::size_t from = 0;  ///< Index of the key scan; the other one follows it.
  LineMatch match{};     ///< In the frame of the scans as stated: mirrored where they are upside down.
  bool usable = false;   ///< It fits, and there is no gap.
  bool gap = false;      ///< Time without scans between the two.
};

struct LidarMotions {
  std::string name;  ///< Scan::sensor.
  Mount stated;      ///< By the log's first scan and the settings.
  std::vector<KeyScan> keys{};
  std::vector<ScanMotion> motions{};
  std::size_t scans = 0;
  std::size_t usable() const;
};

/// What is assumed of the odometry and a LiDAR while its scans are matched.
struct MotionGuess {
  Mount mount;
  double delay_s = 0.0;  ///< The odometry comes so much later than the scans.
};

/// Takes the records of a log as they come. A key scan is taken whenever the LiDAR has moved or turned so far
/// by its scans: by motion, whatever the rates. Not by the odometry: steps would end where its noise makes
/// them long, and its scales come out wrong. Keeps key scans alone, at most kMostKeys of a LiDAR.
/// Deterministic on every machine.
class ScanMotions {
 public:
  /// Long against the noise of a match, short against what scans have in common.
  static constexpr double kKeyStep_m = 0.4, kKeyTurn_rad = 0.4;
  /// Until then scans are linked as often: so far a match finds by itself.
  static constexpr double kChainStep_m = 0.1, kChainTurn_rad = 0.1;
  /// Longer without a scan: nothing is known of what was between.
  static constexpr double kLongestGap_s = 3.0;
  static constexpr std::size_t kMostKeys = 5000;

  /// Both outlive this.
  ScanMotions(const ScanConfig& config, const std::vector<LidarConfig>& lidars)
      : config_(config), settings_(lidars) {}

  void add(const LogRecord& record);
  /// Matches the key scans anew from where `guess` and the odometry say; scans that take time are put right.
  /// False if `keep_going` said so.
  bool match_again(LidarMotions& lidar, const OdometryPath& path, const MotionGuess& guess,
                   const std::function<bool(double fraction)>& keep_going) const;
  bool takes_time(const LidarMotions& lidar) const;

  /// All readings so far; time goes on where stamps run back.
  Trajectory odometry() const;
  std::vector<LidarMotions>& lidars() { return lidars_; }
  std::size_t scans() const { return scans_; }

 private:
  struct Chain {
    LineScan key, linked;  ///< The last key scan, and the last one that was matched.
    Pose linked_odometry;
    Pose since_key;  ///< By the scans.
    double last_s = 0.0, linked_s = 0.0;
    double due_s = 0.0;  ///< When the next scan is to be matched.
    bool unbroken = false;
  };
  double time_of(double stamp_s);
  void add_scan(const LogRecord& record, double time_s);
  static void link(Chain& chain, const LineScan& now, const Pose& odometry, double time_s);
  std::size_t lidar_of(const Scan& scan);
  void start_key(LidarMotions& lidar, Chain& chain, const LogRecord& record, double time_s, LineScan lines);

  const ScanConfig& config_;
  const std::vector<LidarConfig>& settings_;
  std::vector<LidarMotions> lidars_;
  std::vector<Chain> chains_;
  Trajectory readings_;
  double shift_s_ = 0.0, newest_s_ = 0.0;
  std::size_t scans_ = 0;
};

}  // namespace parloc
