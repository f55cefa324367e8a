// CARMEN text logs (docs/logs.md has the formats and the conventions).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/text_fields.h"
#include "common/io/carmen_angles.h"
#include "common/io/carmen_params.h"
#include "common/io/joined_log.h"
#include "common/io/log.h"
#include "common/io/log_limits.h"
#include "common/io/mount_watch.h"
#include "common/math/angle_units.h"
#include "common/math/portable64.h"

namespace parloc {

namespace {

// What a field may be at most: beyond it, arithmetic on the value would lose the metre, the radian or the
// microsecond.
constexpr double kMaxBearingRad = 4.0 * kPi;
constexpr std::size_t kMaxMessages = 20;

Pose read_pose(Fields& fields, const char* what) {
  const double x_m = fields.bounded(what, kMostCoordinate_m);
  const double y_m = fields.bounded(what, kMostCoordinate_m);
  return {x_m, y_m, wrap64(fields.bounded(what, kMostHeading_rad))};
}

// With how finely it is written.
StatedAngle read_angle(Fields& fields, const char* what) {
  const std::string_view text = Fields(fields).text();
  return {fields.bounded(what, kMaxBearingRad), half_last_place(text)};
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
  const double stamp_s = fields.bounded("a time stamp", kMostStamp_s);
  if (!line_is_terminated && fields.empty())
    throw BrokenLine{"expected a whole line, found the end of the file"};
  fields.text();
  fields.text();
  if (!fields.empty()) fields.fail("the end of the line after time stamp, host and logger time stamp");
  return stamp_s;
}

// What FLASER or RLASER lines do not say, decided once for as long as the number of beams and the PARAM lines
// stay.
struct UnsaidOfLine {
  std::size_t beams = 0;  // 0: not decided
  BeamAngles angles;
  Pose T_base_sensor;
  double range_max_m = 0.0;
  bool upside_down = false;
};

class CarmenLog final : public LogReader {
 public:
  /// `raw`: scans are those of RAWLASER lines, and have no odometry.
  CarmenLog(LineReader lines, bool raw) : lines_(std::move(lines)), raw_(raw) {}

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
  void parse_odom(Fields& fields, LogRecord& record) const;
  void parse_without_angles(Fields& fields, LogRecord& record, bool front);
  const UnsaidOfLine& unsaid_of(bool front, std::size_t beams);
  void note_angles(const char* lidar, std::size_t beams, const BeamAngles& angles);
  void parse_robotlaser(Fields& fields, LogRecord& record) const;
  void parse_rawlaser(Fields& fields, LogRecord& record, std::size_t id) const;
  void count_scan(const LogRecord& record);
  void count_broken(const std::string& why);
  void count_unread(std::string_view name);

  LineReader lines_;
  bool raw_;
  LogWarnings warnings_;
  CarmenParams params_;
  MountWatch mounts_;
  UnsaidOfLine unsaid_front_, unsaid_rear_;
  /// Of the scan before, of front, rear and robotlaser1 to 9; 0: none yet.
  std::array<std::size_t, 11> beams_of_sensor_{};
  double last_scan_stamp_s_ = 0.0;
  bool any_scan_ = false;
  bool failure_counted_ = false;
};

// Of any message of CARMEN: in capitals. Words of another file are none.
bool is_message_name(std::string_view name) {
  const auto letter = [](char c) { return c >= 'A' && c <= 'Z'; };
  const auto other = [](char c) { return (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return name.size() >= 3 && name.size() <= 40 && letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return letter(c) || other(c); });
}

constexpr std::string_view kRobotlaser = "ROBOTLASER", kRawlaser = "RAWLASER";

// '1' to '9' for ROBOTLASER1 to ROBOTLASER9, or RAWLASER1 to RAWLASER9; else 0.
char laser_number(std::string_view name, std::string_view kind) {
  const bool is = name.size() == kind.size() + 1 && name.substr(0, kind.size()) == kind;
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
  record.scan.upside_down = false;
  if (name == "ODOM") {
    parse_odom(fields, record);
  } else if (name == "FLASER") {
    record.scan.sensor = "front";
    parse_without_angles(fields, record, true);
  } else if (name == "RLASER") {
    record.scan.sensor = "rear";
    parse_without_angles(fields, record, false);
  } else if (const char number = laser_number(name, kRobotlaser); number != 0) {
    record.scan.sensor = std::string("robotlaser") + number;
    parse_robotlaser(fields, record);
  } else if (const char raw_number = raw_ ? laser_number(name, kRawlaser) : '\0'; raw_number != 0) {
    record.scan.sensor = std::string("rawlaser") + raw_number;
    parse_rawlaser(fields, record, static_cast<std::size_t>(raw_number - '0'));
  } else if (name == "PARAM") {
    params_.take(fields);
    unsaid_front_.beams = unsaid_rear_.beams = 0;
    return false;
  } else if (is_message_name(name)) {
    count_unread(name);
    return false;
  } else {
    throw BrokenLine{"expected a message name, found '" + printable(name) + "'"};
  }
  return true;
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
void CarmenLog::parse_without_angles(Fields& fields, LogRecord& record, bool front) {
  record.kind = RecordKind::scan;
  Scan& scan = record.scan;
  read_ranges(fields, scan.ranges_m);
  for (int i = 0; i < 3; ++i) fields.number<double>("a laser pose");
  record.odometry = read_pose(fields, "finite odometry");
  record.stamp_s = scan.stamp_s = read_end(fields, lines_.terminated());
  const UnsaidOfLine& unsaid = unsaid_of(front, scan.ranges_m.size());
  const double last_rad = unsaid.angles.step_rad * static_cast<double>(unsaid.beams - 1);
  if (!(std::fabs(last_rad) <= kMaxBearingRad))
    throw BrokenLine{fmt::format("expected beams within two turns, found {} in steps of {:g} degrees (PARAM)",
                                 unsaid.beams, unsaid.angles.step_rad / (kPi / 180.0))};
  scan.T_base_sensor = unsaid.T_base_sensor;
  scan.range_min_m = scan.scan_time_s = 0.0;
  scan.range_max_m = unsaid.range_max_m;
  scan.angle_min_rad = unsaid.angles.min_rad;
  scan.angle_step_rad = unsaid.angles.step_rad;
  scan.upside_down = unsaid.upside_down;
}

const UnsaidOfLine& CarmenLog::unsaid_of(bool front, std::size_t beams) {
  UnsaidOfLine& unsaid = front ? unsaid_front_ : unsaid_rear_;
  if (unsaid.beams == beams) return unsaid;
  const CarmenLaser laser = front ? params_.front() : params_.rear();
  unsaid.beams = beams;
  unsaid.angles = angles_of_count(beams, laser.field_of_view, laser.resolution);
  unsaid.T_base_sensor = mount_of(laser, front);
  unsaid.range_max_m = laser.max_range_m.value_or(0.0);
  unsaid.upside_down = laser.flipped.value_or(false);
  if (!unsaid.angles.doubt.empty()) note_angles(front ? "front" : "rear", beams, unsaid.angles);
  return unsaid;
}

void CarmenLog::note_angles(const char* lidar, std::size_t beams, const BeamAngles& angles) {
  for (const LogNote& note : warnings_.notes)
    if (note.about == LogNote::About::angles && note.lidar == lidar) return;
  warnings_.notes.push_back(
      {LogNote::About::angles, lidar,
       fmt::format("{}: the lines say no angles, and {}: taken as {:g} to {:g} degrees in steps of {:g}; "
                   "lidars.{}.angle_min and angle_step [rad] say it otherwise",
                   lidar, angles.doubt, angles.min_rad / kRadPerDeg,
                   (angles.min_rad + angles.step_rad * static_cast<double>(beams - 1)) / kRadPerDeg,
                   angles.step_rad / kRadPerDeg, lidar)});
}

// What ROBOTLASER and RAWLASER lines have in common: <k> type start_angle fov resolution max_range accuracy
// remission_mode n r_1 .. r_n n_remissions remissions. The step is decided last, when the line is known to be
// whole.
struct LaserLine {
  StatedAngle fov, resolution;
};

LaserLine read_laser(Fields& fields, Scan& scan) {
  LaserLine line;
  fields.number<double>("a laser type");
  scan.angle_min_rad = fields.bounded("a start angle within two turns", kMaxBearingRad);
  line.fov = read_angle(fields, "a field of view within two turns");
  line.resolution = read_angle(fields, "an angle step within two turns");
  const double max_range_m = fields.number<double>("a maximum range");
  fields.number<double>("an accuracy");
  fields.number<double>("a remission mode");
  read_ranges(fields, scan.ranges_m);
  const std::size_t remissions = read_count(fields, "a number of remissions");
  for (std::size_t i = 0; i < remissions; ++i) fields.number<double>("a remission");
  scan.range_min_m = scan.scan_time_s = 0.0;
  scan.range_max_m = std::isfinite(max_range_m) && max_range_m > 0.0 ? max_range_m : 0.0;
  return line;
}

void set_step(const LaserLine& line, Scan& scan) {
  scan.angle_step_rad = beam_step_rad(line.fov, line.resolution, scan.ranges_m.size());
  const double last_rad = scan.angle_step_rad * static_cast<double>(scan.ranges_m.size() - 1);
  if (!(std::fabs(last_rad) <= kMaxBearingRad)) throw BrokenLine{"expected beams within two turns"};
  if (scan.ranges_m.size() > 1 && scan.angle_step_rad == 0.0)
    throw BrokenLine{"expected an angle step, found 0"};
}

// ROBOTLASER: ... laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side axis stamp host
// logger_stamp
void CarmenLog::parse_robotlaser(Fields& fields, LogRecord& record) const {
  record.kind = RecordKind::scan;
  Scan& scan = record.scan;
  const LaserLine line = read_laser(fields, scan);
  const Pose T_odom_sensor = read_pose(fields, "a finite laser pose");
  record.odometry = read_pose(fields, "finite odometry");
  for (int i = 0; i < 5; ++i) fields.number<double>("velocities, distances and axis");
  record.stamp_s = scan.stamp_s = read_end(fields, lines_.terminated());
  set_step(line, scan);
  scan.T_base_sensor = relative(T_odom_sensor, record.odometry);
}

// RAWLASER: ... stamp host logger_stamp. Where the laser sits, PARAM lines say.
void CarmenLog::parse_rawlaser(Fields& fields, LogRecord& record, std::size_t id) const {
  record.kind = RecordKind::scan;
  record.odometry = {};
  Scan& scan = record.scan;
  const LaserLine line = read_laser(fields, scan);
  record.stamp_s = scan.stamp_s = read_end(fields, lines_.terminated());
  set_step(line, scan);
  const CarmenLaser laser = params_.of_id(id);
  scan.T_base_sensor = mount_of(laser, id != params_.rear_id());
  scan.upside_down = laser.flipped.value_or(false);
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
  if (auto note = mounts_.look(record)) warnings_.notes.push_back(std::move(*note));
}

// By type, for the first few types: a file may hold any words.
void CarmenLog::count_unread(std::string_view name) {
  ++warnings_.unknown_messages;
  auto& unread = warnings_.unread;
  const auto same = [&](const auto& entry) { return entry.first == name; };
  const auto known = std::find_if(unread.begin(), unread.end(), same);
  if (known != unread.end())
    ++known->second;
  else if (unread.size() < kMaxMessages)
    unread.emplace_back(name, 1);
}

void CarmenLog::count_broken(const std::string& why) {
  ++warnings_.broken_lines;
  if (warnings_.messages.size() < kMaxMessages) {
    warnings_.messages.push_back(fmt::format("{}:{}: {}", lines_.name(), lines_.line(), why));
  }
}

}  // namespace

namespace {

/// Whether its only scans are those of RAWLASER lines: the others have odometry, and are what the recording
/// program made of these.
bool has_raw_scans_alone(LineReader lines) {
  bool raw = false;
  for (std::string_view line; lines.next(line);) {
    const std::string_view name = Fields(line).text();
    if (name == "FLASER" || name == "RLASER" || laser_number(name, kRobotlaser) != 0) return false;
    raw = raw || laser_number(name, kRawlaser) != 0;
  }
  return raw;
}

std::unique_ptr<LogReader> carmen_log(LineReader lines, bool raw, const std::string& name,
                                      bool without_odometry) {
  auto log = std::make_unique<CarmenLog>(std::move(lines), raw);
  if (raw && !without_odometry) return join_odometry(std::move(log), name);
  return log;
}

}  // namespace

std::unique_ptr<LogReader> open_carmen_log(const std::string& path, bool without_odometry) {
  // What is no file, such as a pipe, can be read only once.
  std::error_code none;
  const bool raw =
      std::filesystem::is_regular_file(path, none) && has_raw_scans_alone(LineReader::from_file(path));
  return carmen_log(LineReader::from_file(path), raw, path, without_odometry);
}

std::unique_ptr<LogReader> carmen_log_from_text(const std::string& text, const std::string& name,
                                                bool without_odometry) {
  const bool raw = has_raw_scans_alone(LineReader::from_text(text, name));
  return carmen_log(LineReader::from_text(text, name), raw, name, without_odometry);
}

}  // namespace parloc
