// What a StepFrontEnd remembers of the drive so far, in a checkpoint.
#include <algorithm>
#include <cmath>

#include "common/slam/checkpoint_values.h"

namespace parloc {
namespace {

/// Readings of the odometry whose stamps stood still, more than a ContinuousOdometry counts.
constexpr std::uint64_t kMostStoodStill = 100;

std::vector<StampedPose> get_readings(ByteReader& r) {
  std::vector<StampedPose> readings = get_trajectory(r);
  const auto no_later = [](const StampedPose& a, const StampedPose& b) { return !(a.stamp_s < b.stamp_s); };
  const auto wrong = std::adjacent_find(readings.begin(), readings.end(), no_later);
  const bool finite = std::all_of(readings.begin(), readings.end(),
                                  [](const StampedPose& p) { return std::isfinite(p.stamp_s); });
  r.expect(wrong == readings.end() && finite, "odometry in order");
  return readings;
}

/// Every count of a LidarUse, in the order of the file.
template <class Use, class Visit>
void visit_counts(Use& use, const Visit& visit) {
  auto& b = use.beams;
  for (auto* count :
       {&use.scans, &use.too_few, &use.smallest, &use.largest, &use.moving, &use.unknown_motion, &b.total,
        &b.considered, &b.used, &b.misses, &b.nan, &b.infinite, &b.negative, &b.zero, &b.below_min})
    visit(*count);
}

void put_odometry_memory(ByteWriter& w, const std::optional<OdometryMemory>& memory) {
  w.put_bool(memory.has_value());
  if (!memory) return;
  for (const Pose& pose : {memory->raw, memory->pose, memory->step}) put_pose(w, pose);
  for (const double time_s : {memory->stamp_s, memory->step_s, memory->since_s, memory->pace_s})
    w.put(time_s);
  w.put_count(static_cast<std::size_t>(memory->stood_still));
  w.put_count(static_cast<std::size_t>(memory->paced));
  w.put_bool(memory->rebased);
}
std::optional<OdometryMemory> get_odometry_memory(ByteReader& r) {
  if (!r.get_bool()) return std::nullopt;
  OdometryMemory memory;
  for (Pose* pose : {&memory.raw, &memory.pose, &memory.step}) *pose = get_pose(r);
  for (double* time_s : {&memory.stamp_s, &memory.step_s, &memory.since_s, &memory.pace_s}) {
    *time_s = r.get<double>();
    r.expect(std::isfinite(*time_s), "times of the odometry that are numbers");
  }
  const auto stood_still = r.get<std::uint64_t>();
  r.expect(stood_still <= kMostStoodStill, "a count of stamps that can be");
  memory.stood_still = static_cast<int>(stood_still);
  const auto paced = r.get<std::uint64_t>();
  r.expect(paced <= kMostStoodStill && memory.pace_s >= 0.0, "a pace of stamps that can be");
  memory.paced = static_cast<int>(paced);
  memory.rebased = r.get_bool();
  return memory;
}
void put_scaler_memory(ByteWriter& w, const std::optional<OdometryScaler::Memory>& memory) {
  w.put_bool(memory.has_value());
  if (memory) put_pose(w, memory->raw), put_pose(w, memory->pose);
}
std::optional<OdometryScaler::Memory> get_scaler_memory(ByteReader& r) {
  if (!r.get_bool()) return std::nullopt;
  const Pose raw = get_pose(r);
  return OdometryScaler::Memory{raw, get_pose(r)};
}
void put_lidars(ByteWriter& w, const std::vector<LidarUse>& lidars) {
  w.put_each(lidars, [](ByteWriter& out, const LidarUse& use) {
    out.put_text(use.name);
    out.put(std::int32_t{use.max_beams});
    visit_counts(use, [&](const std::size_t& count) { out.put_count(count); });
  });
}
std::vector<LidarUse> get_lidars(ByteReader& r) {
  return r.get_each(132, [](ByteReader& in) {
    LidarUse use;
    use.name = in.get_text();
    use.max_beams = in.get<std::int32_t>();
    visit_counts(use, [&](std::size_t& count) { count = in.get<std::uint64_t>(); });
    return use;
  });
}
void put_stamps(ByteWriter& w, const std::vector<LidarStamps>& stamps) {
  w.put_each(stamps, [](ByteWriter& out, const LidarStamps& s) {
    for (const auto& stamp_s : {s.last_s, s.newest_s, s.refused_s}) {
      out.put_bool(stamp_s.has_value());
      if (stamp_s) out.put(*stamp_s);
    }
    out.put(std::int32_t{s.older});
  });
}
std::vector<LidarStamps> get_stamps(ByteReader& r, std::size_t lidars) {
  std::vector<LidarStamps> stamps = r.get_each(7, [](ByteReader& in) {
    LidarStamps s;
    for (auto* stamp_s : {&s.last_s, &s.newest_s, &s.refused_s}) {
      if (in.get_bool()) *stamp_s = in.get<double>();
      in.expect(std::isfinite(stamp_s->value_or(0.0)), "stamps that are numbers");
    }
    s.older = in.get<std::int32_t>();
    in.expect(s.last_s.has_value() == s.newest_s.has_value() && s.older >= 0 && s.older < 1000,
              "stamps that a LiDAR can have had");
    return s;
  });
  r.expect(stamps.size() == lidars, "stamps of every LiDAR");
  return stamps;
}

}  // namespace

void put_front_end(ByteWriter& w, const StepFrontEnd& front_end) {
  put_trajectory(w, front_end.track().readings());
  put_lidars(w, front_end.lidars_used());
  put_stamps(w, front_end.stamps());
  w.put_bool(front_end.jumped());
  w.put_bool(front_end.odometry().has_value());
  if (front_end.odometry()) put_pose(w, *front_end.odometry());
  put_odometry_memory(w, front_end.continuous().memory());
  if (front_end.scaler().active()) put_scaler_memory(w, front_end.scaler().memory());
}

void get_front_end(ByteReader& r, StepFrontEnd& front_end) {
  front_end.track().set_readings(get_readings(r));
  front_end.set_lidars_used(get_lidars(r));
  front_end.set_stamps(get_stamps(r, front_end.lidars_used().size()));
  front_end.set_jumped(r.get_bool());
  if (r.get_bool()) front_end.set_odometry(get_pose(r));
  front_end.continuous().restore(get_odometry_memory(r));
  if (front_end.scaler().active()) front_end.scaler().restore(get_scaler_memory(r));
}

}  // namespace parloc
