#include "tools/log/converted_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/mcap/mcap_log.h"

namespace parloc::tools {
namespace {

bool same(const Pose& a, const Pose& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.theta_rad == b.theta_rad;
}

/// The topic whose LiDAR has this name for who reads it.
std::string topic_of(const std::string& sensor) {
  if (sensor.empty()) return "/scan";
  const std::string topic = "/" + sensor;
  const bool taken = topic == "/odom" || topic == "/tf" || topic == "/tf_static";
  return taken ? topic + "/scan" : topic;
}

class ConvertedMcap final : public ConvertedLog {
 public:
  explicit ConvertedMcap(McapWriter::Sink sink) : log_(std::move(sink)) {}

  void write(const LogRecord& record) override {
    if (waiting_ && (record.kind == RecordKind::odometry || record.stamp_s != waiting_->stamp_s)) flush();
    if (record.kind == RecordKind::odometry) {
      waiting_ = {record.stamp_s, record.odometry};
      return;
    }
    write_scans_odometry(record);
    log_.write_scan(topic_of(record.scan.sensor), record.scan);
  }

  void finish() override {
    if (waiting_) flush();
    log_.finish();
  }

  std::vector<std::string> losses() const override {
    std::vector<std::string> lines;
    if (replaced_ > 0)
      lines.push_back(
          fmt::format("{} odometry readings have the stamp of a scan with other odometry: the scan's is kept",
                      replaced_));
    if (shared_ > 0)
      lines.push_back(
          fmt::format("{} scans have the stamp of the scan before, but other odometry: at one time there is "
                      "one, the first",
                      shared_));
    if (const std::vector<std::string> moving = log_.moving(); !moving.empty())
      lines.push_back(fmt::format("{}: its place on the robot changes from scan to scan: /tf says it of each",
                                  fmt::join(moving, ", ")));
    return lines;
  }

 private:
  /// A scan's own odometry, by which it will be read. A reading of the same stamp would be in its way.
  void write_scans_odometry(const LogRecord& record) {
    if (waiting_ && !same(waiting_->pose, record.odometry)) ++replaced_;
    waiting_.reset();
    if (last_scan_ && last_scan_->stamp_s == record.stamp_s) {
      shared_ += same(last_scan_->pose, record.odometry) ? 0 : 1;
      return;
    }
    log_.write_odometry(record.stamp_s, record.odometry);
    last_scan_ = {record.stamp_s, record.odometry};
  }
  void flush() {
    log_.write_odometry(waiting_->stamp_s, waiting_->pose);
    waiting_.reset();
  }

  McapLog log_;
  std::optional<StampedPose> waiting_;    ///< Odometry that is written unless a scan of its stamp follows.
  std::optional<StampedPose> last_scan_;  ///< Its odometry.
  std::size_t replaced_ = 0, shared_ = 0;
};

class ConvertedCarmen final : public ConvertedLog {
 public:
  explicit ConvertedCarmen(McapWriter::Sink sink) : sink_(std::move(sink)) {}

  void write(const LogRecord& record) override {
    if (record.kind == RecordKind::odometry) {
      const Pose& p = record.odometry;
      sink_(fmt::format("ODOM {} {} {} 0 0 0 {} parloc {}\n", p.x_m, p.y_m, p.theta_rad, record.stamp_s,
                        record.stamp_s));
      return;
    }
    const Scan& scan = record.scan;
    if (!scan.bearings_rad.empty() || !scan.beam_times_s.empty())
      throw Error(ErrorKind::input, fmt::format("{} has angles or times for each beam: expected even ones, "
                                                "which is all that a ROBOTLASER line holds",
                                                printable(scan.sensor)));
    minimum_ += scan.range_min_m > 0.0 ? 1 : 0;
    takes_time_ += scan.scan_time_s > 0.0 ? 1 : 0;
    LogRecord numbered = record;
    numbered.scan.sensor = fmt::format("robotlaser{}", number_of(scan.sensor));
    sink_(carmen_line(numbered, CarmenDigits::all) + "\n");
  }

  void finish() override {}

  std::vector<std::string> losses() const override {
    std::vector<std::string> lines;
    if (minimum_ > 0)
      lines.push_back(
          fmt::format("the minimum range of {} scans is not kept: no CARMEN line says it", minimum_));
    if (takes_time_ > 0)
      lines.push_back(fmt::format("how long {} scans take is not kept: no CARMEN line says it", takes_time_));
    for (const auto& [name, number] : numbers_)
      if (name != fmt::format("robotlaser{}", number))
        lines.push_back(fmt::format("{} is robotlaser{}", printable(name), number));
    return lines;
  }

 private:
  /// 1 to 9: that of its name, else the first that no other has.
  int number_of(const std::string& sensor) {
    const auto known = numbers_.find(sensor);
    if (known != numbers_.end()) return known->second;
    std::array<bool, 10> taken{true};
    for (const auto& [name, number] : numbers_) taken[static_cast<std::size_t>(number)] = true;
    auto at = static_cast<std::size_t>(std::find(taken.begin(), taken.end(), false) - taken.begin());
    for (std::size_t own = 1; own <= 9; ++own)
      if (sensor == fmt::format("robotlaser{}", own) && !taken[own]) at = own;
    if (at == taken.size())
      throw Error(ErrorKind::input, "expected at most nine LiDARs, which is all that CARMEN has names for");
    return numbers_[sensor] = static_cast<int>(at);
  }

  McapWriter::Sink sink_;
  std::map<std::string, int> numbers_;
  std::size_t minimum_ = 0, takes_time_ = 0;
};

}  // namespace

std::unique_ptr<ConvertedLog> convert_to_mcap(McapWriter::Sink sink) {
  return std::make_unique<ConvertedMcap>(std::move(sink));
}

std::unique_ptr<ConvertedLog> convert_to_carmen(McapWriter::Sink sink) {
  return std::make_unique<ConvertedCarmen>(std::move(sink));
}

}  // namespace parloc::tools
