// CARMEN text logs (docs/logs.md has the formats and the conventions).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/text_fields.h"
#include "common/io/log.h"
#include "common/math/portable64.h"

namespace parloc {

namespace {

// What a field may be at most: beyond it, arithmetic on the value would lose the metre, the radian or the
// microsecond.
constexpr double kMaxCoordinateM = 1e8;
constexpr double kMaxHeadingRad = 1e6;
constexpr double kMaxStampS = 1e12;
constexpr double kMaxBearingRad = 4.0 * kPi;
constexpr std::size_t kMaxMessages = 20;

struct Mounts {
  Pose T_base_front;
  Pose T_base_rear{0.0, 0.0, -kPi};  // looks backwards
};

Pose read_pose(Fields& fields, const char* what) {
  const double x_m = fields.bounded(what, kMaxCoordinateM);
  const double y_m = fields.bounded(what, kMaxCoordinateM);
  return {x_m, y_m, wrap64(fields.bounded(what, kMaxHeadingRad))};
}

// The count of items that follow, bounded by what the line can hold: an item takes two bytes at least.
std::size_t read_count(Fields& fields, const char* what) {
  const auto count = fields.number<std::size_t>(what);
  if (count > fields.bytes_left() / 2) {
    throw BrokenLine{fmt::format("expected {}, found {}, more than the line holds", what, count)};
  }
  return count;
}

void read_ranges(Fields& fields, std::vector<float>& ranges_m) {
  ranges_m.clear();
  const std::size_t count = read_count(fields, "a number of ranges");
  if (count == 0) throw BrokenLine{"expected at least one range, found 0"};
  for (std::size_t i = 0; i < count; ++i) ranges_m.push_back(fields.number<float>("a range"));
}

// The stamp, then the host and the logger's own stamp: a line that holds anything else has been read wrongly.
double read_end(Fields& fields, bool line_is_terminated) {
  const double stamp_s = fields.bounded("a time stamp", kMaxStampS);
  if (!line_is_terminated && fields.empty())
    throw BrokenLine{"expected a whole line, found the end of the file"};
  fields.text();
  fields.text();
  if (!fields.empty()) fields.fail("the end of the line after time stamp, host and logger time stamp");
  return stamp_s;
}

// FLASER and RLASER carry no angles. An even count leaves the last end of the half circle out (180 beams: 1
// degree, 360: 0.5), an odd count has both (181, 361): so the logs of the common SICK modes are right, and
// the rest follow.
void set_half_circle(Scan& scan) {
  const std::size_t n = scan.ranges_m.size();
  scan.angle_min_rad = n == 1 ? 0.0 : -kPi / 2.0;
  scan.angle_step_rad = n == 1 ? 0.0 : kPi / static_cast<double>(n % 2 == 0 ? n : n - 1);
}

// The field of view divided by the number of steps is closer to the truth than a resolution rounded to 6
// decimals, whose error grows with the beam index. Logs count the steps either way; the resolution tells
// which.
double step_from(double fov_rad, double resolution_rad, std::size_t beams) {
  if (beams < 2) return resolution_rad;
  const double n = static_cast<double>(beams);
  const double both_ends = fov_rad / (n - 1.0);
  const double one_end = fov_rad / n;
  if (resolution_rad == 0.0) return both_ends;
  const bool first = std::fabs(both_ends - resolution_rad) <= std::fabs(one_end - resolution_rad);
  const double candidate = first ? both_ends : one_end;
  return std::fabs(candidate - resolution_rad) <= 1e-6 ? candidate : resolution_rad;
}

class CarmenLog final : public LogReader {
 public:
  explicit CarmenLog(LineReader lines) : lines_(std::move(lines)) {}

  bool next(LogRecord& record) override {
    std::string_view line;
    while (lines_.next(line)) {
      if (!lines_.terminated() && !lines_.failure().empty()) break;  // half a line: part of the failure below
      try {
        if (lines_.cut())
          throw BrokenLine{fmt::format("expected at most {} bytes", LineReader::max_line_bytes)};
        if (parse(line, record)) {
          if (record.kind == RecordKind::scan) count_scan(record);
          return true;
        }
      } catch (const BrokenLine& broken) {
        count_broken(broken.why);
      }
    }
    if (!lines_.failure().empty() && !std::exchange(failure_counted_, true)) count_broken(lines_.failure());
    return false;
  }

  const LogWarnings& warnings() const override { return warnings_; }
  double progress() const override { return lines_.progress(); }

 private:
  bool parse(std::string_view line, LogRecord& record);
  void parse_param(Fields& fields);
  void parse_odom(Fields& fields, LogRecord& record) const;
  void parse_half_circle(Fields& fields, LogRecord& record, const Pose& T_base_sensor) const;
  void parse_robotlaser(Fields& fields, LogRecord& record) const;
  void count_scan(const LogRecord& record);
  void count_broken(const std::string& why);

  LineReader lines_;
  LogWarnings warnings_;
  Mounts mounts_;
  /// Of the scan before, of front, rear and robotlaser1 to 9; 0: none yet.
  std::array<std::size_t, 11> beams_of_sensor_{};
  double last_scan_stamp_s_ = 0.0;
  bool any_scan_ = false;
  bool failure_counted_ = false;
};

bool is_message_name(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  const auto other = [](char c) { return (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return name.size() <= 40 && letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return letter(c) || other(c); });
}

constexpr std::string_view kRobotlaser = "ROBOTLASER";

// '1' to '9' for ROBOTLASER1 to ROBOTLASER9, else 0.
char robotlaser_number(std::string_view name) {
  const bool is = name.size() == kRobotlaser.size() + 1 && name.substr(0, kRobotlaser.size()) == kRobotlaser;
  return is && name.back() >= '1' && name.back() <= '9' ? name.back() : '\0';
}

// True if the line gave a record.
bool CarmenLog::parse(std::string_view line, LogRecord& record) {
  Fields fields(line);
  const std::string_view name = fields.text();
  if (name.empty() || name.front() == '#') return false;
  record.line = lines_.line();
  record.scan.ranges_m.clear();
  record.scan.sensor.clear();
  record.scan.bearings_rad.clear();
  record.scan.beam_times_s.clear();
  if (name == "ODOM") {
    parse_odom(fields, record);
  } else if (name == "FLASER") {
    record.scan.sensor = "front";
    parse_half_circle(fields, record, mounts_.T_base_front);
  } else if (name == "RLASER") {
    record.scan.sensor = "rear";
    parse_half_circle(fields, record, mounts_.T_base_rear);
  } else if (const char number = robotlaser_number(name); number != 0) {
    record.scan.sensor = std::string("robotlaser") + number;
    parse_robotlaser(fields, record);
  } else if (name == "PARAM") {
    parse_param(fields);
    return false;
  } else if (is_message_name(name)) {
    ++warnings_.unknown_messages;
    return false;
  } else {
    throw BrokenLine{"expected a message name, found '" + printable(name) + "'"};
  }
  return true;
}

void CarmenLog::parse_param(Fields& fields) {
  const std::string_view name = fields.text();
  // Logs give the rear distance with either sign; the sensor is behind the base.
  if (name == "robot_frontlaser_offset") {
    mounts_.T_base_front.x_m = fields.bounded("an offset in metres", kMaxCoordinateM);
  } else if (name == "robot_rearlaser_offset") {
    mounts_.T_base_rear.x_m = -std::fabs(fields.bounded("an offset in metres", kMaxCoordinateM));
  }
}

// ODOM x y theta tv rv accel stamp host logger_stamp
void CarmenLog::parse_odom(Fields& fields, LogRecord& record) const {
  record.kind = RecordKind::odometry;
  record.odometry = read_pose(fields, "finite odometry");
  for (int i = 0; i < 3; ++i) fields.number<double>("a velocity");
  record.stamp_s = read_end(fields, lines_.terminated());
}

// FLASER n r_1 .. r_n x y theta odom_x odom_y odom_theta stamp host logger_stamp. The first pose is the
// laser's, by the recording program's own reckoning; the odometry proper is the second.
void CarmenLog::parse_half_circle(Fields& fields, LogRecord& record, const Pose& T_base_sensor) const {
  record.kind = RecordKind::scan;
  Scan& scan = record.scan;
  read_ranges(fields, scan.ranges_m);
  for (int i = 0; i < 3; ++i) fields.number<double>("a laser pose");
  record.odometry = read_pose(fields, "finite odometry");
  record.stamp_s = scan.stamp_s = read_end(fields, lines_.terminated());
  scan.T_base_sensor = T_base_sensor;
  scan.range_min_m = scan.range_max_m = scan.scan_time_s = 0.0;
  set_half_circle(scan);
}

// ROBOTLASER<k> type start_angle fov resolution max_range accuracy remission_mode n r_1 .. r_n n_remissions
// remissions
//   laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side axis stamp host logger_stamp
void CarmenLog::parse_robotlaser(Fields& fields, LogRecord& record) const {
  record.kind = RecordKind::scan;
  Scan& scan = record.scan;
  fields.number<double>("a laser type");
  scan.angle_min_rad = fields.bounded("a start angle within two turns", kMaxBearingRad);
  const double fov_rad = fields.bounded("a field of view within two turns", kMaxBearingRad);
  const double resolution_rad = fields.bounded("an angle step within two turns", kMaxBearingRad);
  const double max_range_m = fields.number<double>("a maximum range");
  fields.number<double>("an accuracy");
  fields.number<double>("a remission mode");
  read_ranges(fields, scan.ranges_m);
  const std::size_t remissions = read_count(fields, "a number of remissions");
  for (std::size_t i = 0; i < remissions; ++i) fields.number<double>("a remission");
  const Pose T_odom_sensor = read_pose(fields, "a finite laser pose");
  record.odometry = read_pose(fields, "finite odometry");
  for (int i = 0; i < 5; ++i) fields.number<double>("velocities, distances and axis");
  record.stamp_s = scan.stamp_s = read_end(fields, lines_.terminated());

  scan.angle_step_rad = step_from(fov_rad, resolution_rad, scan.ranges_m.size());
  const double last_rad = scan.angle_step_rad * static_cast<double>(scan.ranges_m.size() - 1);
  if (!(std::fabs(last_rad) <= kMaxBearingRad)) throw BrokenLine{"expected beams within two turns"};
  if (scan.ranges_m.size() > 1 && scan.angle_step_rad == 0.0)
    throw BrokenLine{"expected an angle step, found 0"};
  scan.T_base_sensor = relative(T_odom_sensor, record.odometry);
  scan.range_min_m = scan.scan_time_s = 0.0;
  scan.range_max_m = std::isfinite(max_range_m) && max_range_m > 0.0 ? max_range_m : 0.0;
}

std::size_t sensor_index(const std::string& name) {
  if (name == "front") return 0;
  return name == "rear" ? 1 : 1 + static_cast<std::size_t>(name.back() - '0');
}

void CarmenLog::count_scan(const LogRecord& record) {
  if (any_scan_ && record.stamp_s < last_scan_stamp_s_) ++warnings_.backward_stamps;
  any_scan_ = true;
  last_scan_stamp_s_ = record.stamp_s;
  std::size_t& beams = beams_of_sensor_[sensor_index(record.scan.sensor)];
  if (beams != 0 && beams != record.scan.ranges_m.size()) ++warnings_.beam_count_changes;
  beams = record.scan.ranges_m.size();
}

void CarmenLog::count_broken(const std::string& why) {
  ++warnings_.broken_lines;
  if (warnings_.messages.size() < kMaxMessages) {
    warnings_.messages.push_back(fmt::format("{}:{}: {}", lines_.name(), lines_.line(), why));
  }
}

}  // namespace

std::unique_ptr<LogReader> open_carmen_log(const std::string& path) {
  return std::make_unique<CarmenLog>(LineReader::from_file(path));
}

std::unique_ptr<LogReader> carmen_log_from_text(const std::string& text, const std::string& name) {
  return std::make_unique<CarmenLog>(LineReader::from_text(text, name));
}

std::string carmen_line(const LogRecord& record) {
  const Scan& scan = record.scan;
  const std::size_t n = scan.ranges_m.size();
  const double fov_rad = n > 0 ? scan.angle_step_rad * static_cast<double>(n - 1) : 0.0;
  const Pose& robot = record.odometry;
  const Pose laser = compose(robot, scan.T_base_sensor);
  std::string line;
  auto out = std::back_inserter(line);
  const bool numbered = scan.sensor.size() == 11 && scan.sensor.rfind("robotlaser", 0) == 0;
  const char number = numbered ? robotlaser_number(std::string(kRobotlaser) + scan.sensor.back()) : '\0';
  fmt::format_to(out, "ROBOTLASER{} 0 {:.9f} {:.9f} {:.9f} {:.6f} 0.010000 0 {}", number != 0 ? number : '1',
                 scan.angle_min_rad, fov_rad, scan.angle_step_rad, scan.range_max_m, n);
  for (const float range_m : scan.ranges_m) fmt::format_to(out, " {:.4f}", range_m);
  fmt::format_to(out, " 0 {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} 0 0 0 0 0 {:.6f} parloc {:.6f}",
                 laser.x_m, laser.y_m, laser.theta_rad, robot.x_m, robot.y_m, robot.theta_rad, scan.stamp_s,
                 scan.stamp_s);
  return line;
}

}  // namespace parloc
