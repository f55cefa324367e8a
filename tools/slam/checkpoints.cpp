#include "tools/slam/checkpoints.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/error.h"

namespace parloc::tools::slam {
namespace {

void add(Sha256& sha, const Pose& pose) {
  sha.add(pose.x_m), sha.add(pose.y_m), sha.add(pose.theta_rad);
}

/// The number of values first, so that none can pass for one of the next array.
template <class Number>
void add(Sha256& sha, const std::vector<Number>& values) {
  sha.add(static_cast<double>(values.size()));
  for (const Number v : values) sha.add(v);
}

void add(Sha256& sha, const Scan& scan) {
  sha.add(static_cast<double>(scan.sensor.size()));
  sha.add(scan.sensor.data(), scan.sensor.size());
  add(sha, scan.T_base_sensor);
  for (const double v : {scan.stamp_s, scan.angle_min_rad, scan.angle_step_rad, scan.range_min_m,
                         scan.range_max_m, scan.scan_time_s})
    sha.add(v);
  add(sha, scan.ranges_m);
  add(sha, scan.bearings_rad);
  add(sha, scan.beam_times_s);
  if (scan.upside_down) sha.add(1.0);  // only then: digests of older checkpoints stay
}

double seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

Error another_log(const MapRequest& request, const MapPosition& from) {
  return input_error(
      request.log_name, 0,
      fmt::format("expected the log of the checkpoint, {}, found another in its first {} scans",
                  from.log_name, from.scans));
}

}  // namespace

bool DigestedLog::next(LogRecord& record) {
  if (!log_.next(record)) return false;
  const bool is_scan = record.kind == RecordKind::scan;
  sha_.add(is_scan ? 1.0 : 0.0);
  sha_.add(record.stamp_s);
  add(sha_, record.odometry);
  if (is_scan) add(sha_, record.scan);
  return true;
}

Checkpoints::Checkpoints(const MapRequest& request, const DigestedLog& log)
    : request_(request), log_(log), pause_s_(request.checkpoint_every_s) {
  if (request.resume == nullptr) return;
  name_ = request.resume->name();
  from_ = map_position_from(request.resume->own, name_);
}

void Checkpoints::check(const GridSlam& slam) const {
  if (from_.step_s.size() != slam.records().size())
    throw input_error(name_, 0,
                      fmt::format("damaged: expected times of {} scans, found {}", slam.records().size(),
                                  from_.step_s.size()));
}

void Checkpoints::restore(tools::EvenSample<Growth>& growth) {
  if (!growth.restore(std::move(from_.growth), from_.step_s.size()))
    throw input_error(name_, 0, "damaged: expected as many moments of the map as there were scans for");
}

bool Checkpoints::has_next(std::size_t scans) const {
  expect_same(scans);
  return scans < from_.scans;
}

void Checkpoints::expect_passed(std::size_t scans) const {
  if (scans < from_.scans) throw another_log(request_, from_);
  expect_same(scans);
}

void Checkpoints::expect_same(std::size_t scans) const {
  if (scans == from_.scans && scans > 0 && log_.digest() != from_.digest) throw another_log(request_, from_);
}

void Checkpoints::write_when_due(const GridSlam& slam, const Mapping& m, const std::vector<Growth>& growth) {
  if (request_.checkpoint_every_s > 0.0 && seconds(Clock::now() - written_) >= pause_s_)
    write(slam, m, growth);
}

void Checkpoints::write(const GridSlam& slam, const Mapping& m, const std::vector<Growth>& growth) {
  if (request_.checkpoint.empty()) return;
  const Clock::time_point begun = Clock::now();
  slam.save(request_.checkpoint, to_bytes({request_.log_name, m.scans, log_.digest(), m.step_s, wall_s(),
                                           m.odometry_chosen, growth}));
  constexpr double kMostShare = 0.05;  // of the time, however large the state has become
  written_ = Clock::now();
  pause_s_ = std::max(request_.checkpoint_every_s, seconds(written_ - begun) / kMostShare);
}

double Checkpoints::wall_s() const {
  return from_.wall_s + seconds(Clock::now() - begun_);
}

}  // namespace parloc::tools::slam
