#include "common/io/odometry_joiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace parloc {

namespace {
// A scan arrives when its last beam has been taken, and through a slow network: so long it is waited for.
constexpr double kLatestScan_s = 5.0;
constexpr std::size_t kMostReadings = 20000, kMostScans = 1000, kMostScansLive = 50;
constexpr std::size_t kClockWasSet = 10;
}  // namespace

void OdometryJoiner::add_odometry(double stamp_s, const Pose& odometry, std::size_t line) {
  odometry_times_.add(stamp_s);
  if (!readings_.empty() && stamp_s < readings_.front().stamp_s) {
    // Older than all that is remembered: a straggler, unless it goes on so. Then the clock was set back.
    if (++stale_in_a_row_ < kClockWasSet) return;
    after_ += scans_.size();
    scans_.clear();
    readings_.clear();
    given_ = 0;
  }
  stale_in_a_row_ = 0;
  auto at = readings_.end();
  while (at != readings_.begin() && std::prev(at)->stamp_s > stamp_s) --at;
  const auto index = static_cast<std::size_t>(at - readings_.begin());
  readings_.insert(at, {stamp_s, odometry, line});
  if (index < given_) ++given_;
}

void OdometryJoiner::add_scan(LogRecord scan) {
  scan_times_.add(scan.stamp_s);
  if (scans_.size() >= (live_ ? kMostScansLive : kMostScans)) {
    ++after_;
    scans_.pop_front();
  }
  auto at = scans_.end();
  while (at != scans_.begin() && std::prev(at)->stamp_s > scan.stamp_s) --at;
  scans_.insert(at, std::move(scan));
}

std::vector<std::string> OdometryJoiner::left_out(const std::string& log_name) const {
  std::vector<std::string> lines;
  const auto add = [&](std::size_t count, const char* when) {
    if (count > 0)
      lines.push_back(fmt::format("{}: {} scan{} {} left out", log_name, count, count == 1 ? "" : "s", when));
  };
  add(before_, "before the first odometry");
  add(after_, "after the last odometry");
  return lines;
}

std::string OdometryJoiner::why_none() const {
  const auto text = [](const Times& times) {
    return fmt::format("from {:.3f} to {:.3f} s", times.first_s, times.last_s);
  };
  if (!odometry_times_.any) return "expected odometry, found scans alone";
  return fmt::format("no scan lies between two readings of the odometry: scans {}, odometry {}",
                     text(scan_times_), text(odometry_times_));
}

// The next reading that has not come out, if it is of before that time.
bool OdometryJoiner::give_reading(double before_s, LogRecord& record) {
  if (given_ >= readings_.size() || !(readings_[given_].stamp_s < before_s)) return false;
  const Reading& reading = readings_[given_++];
  record.kind = RecordKind::odometry;
  record.stamp_s = reading.stamp_s;
  record.odometry = reading.odometry;
  record.line = reading.line;
  record.scan = {};
  forget();
  return true;
}

// What is long past; scans that wait, and some that are still to come, need the rest.
void OdometryJoiner::forget() {
  double until_s = readings_.back().stamp_s - 2.0 * kLatestScan_s;
  if (!scans_.empty()) until_s = std::min(until_s, scans_.front().stamp_s);
  while (given_ > 1 && (readings_[1].stamp_s < until_s || readings_.size() > kMostReadings)) {
    readings_.pop_front();
    --given_;
  }
}

// The scan's odometry; false if there is no reading before it, or none after.
bool OdometryJoiner::join(LogRecord& scan) {
  const auto later = [](const Reading& r, double stamp_s) { return r.stamp_s < stamp_s; };
  const auto at = std::lower_bound(readings_.begin(), readings_.end(), scan.stamp_s, later);
  if (at == readings_.end() || (at == readings_.begin() && at->stamp_s != scan.stamp_s)) {
    ++(at == readings_.end() ? after_ : before_);
    return false;
  }
  if (at->stamp_s == scan.stamp_s) {
    scan.odometry = at->odometry;
    given_ = std::max(given_, static_cast<std::size_t>(at - readings_.begin()) + 1);
    return true;
  }
  const auto before = std::prev(at);
  const double gap_s = at->stamp_s - before->stamp_s;
  longest_gap_s_ = std::max(longest_gap_s_, gap_s);
  scan.odometry = blend(before->odometry, at->odometry, (scan.stamp_s - before->stamp_s) / gap_s);
  return true;
}

bool OdometryJoiner::next(LogRecord& record) {
  for (;;) {
    if (scans_.empty()) {
      const bool full = readings_.size() > kMostReadings;
      const double newest_s = readings_.empty() ? 0.0 : readings_.back().stamp_s;
      if (finished_ || full || live_) return give_reading(newest_s + 1.0, record);
      return !readings_.empty() && give_reading(newest_s - kLatestScan_s, record);
    }
    const LogRecord& scan = scans_.front();
    const bool reached = !readings_.empty() && readings_.back().stamp_s >= scan.stamp_s;
    if (!reached && !finished_) return false;
    if (give_reading(scan.stamp_s, record)) return true;
    record = std::move(scans_.front());
    scans_.pop_front();
    if (join(record)) return true;
  }
}

}  // namespace parloc
