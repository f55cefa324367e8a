#include "common/eval/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "common/error.h"
#include "common/file/line_reader.h"
#include "common/file/text_rows.h"
#include "common/math/portable64.h"
#include "common/math/quantile.h"

namespace parloc {

namespace {

// Stamps are equal when they are equal to 6 decimals, as the files have them.
std::int64_t microseconds(double stamp_s) {
  return std::llround(stamp_s * 1e6);
}

/// The poses of a trajectory by their stamp; of several with one stamp, the first.
class StampIndex {
 public:
  explicit StampIndex(const Trajectory& rows) {
    for (const StampedPose& row : rows) poses_.emplace(microseconds(row.stamp_s), row.pose);
  }
  std::size_t size() const { return poses_.size(); }
  const Pose* find(double stamp_s) const {
    const auto found = poses_.find(microseconds(stamp_s));
    return found == poses_.end() ? nullptr : &found->second;
  }

 private:
  std::unordered_map<std::int64_t, Pose> poses_;
};

/// The truth at any time.
class Truth {
 public:
  Truth(const Trajectory& rows, double max_gap_s) : exact_(rows), by_time_(rows), max_gap_s_(max_gap_s) {
    std::stable_sort(by_time_.begin(), by_time_.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; });
  }

  std::optional<Pose> at(double stamp_s) const {
    if (const Pose* pose = exact_.find(stamp_s)) return *pose;
    const auto after = std::upper_bound(by_time_.begin(), by_time_.end(), stamp_s,
                                        [](double t, const StampedPose& row) { return t < row.stamp_s; });
    if (after == by_time_.begin() || after == by_time_.end()) return std::nullopt;
    const StampedPose& a = *(after - 1);
    const StampedPose& b = *after;
    const double gap_s = b.stamp_s - a.stamp_s;
    if (gap_s > max_gap_s_) return std::nullopt;
    return blend(a.pose, b.pose, (stamp_s - a.stamp_s) / gap_s);
  }

 private:
  StampIndex exact_;
  Trajectory by_time_;
  double max_gap_s_;
};

struct Summary {
  double mean_abs = 0.0, rmse = 0.0, max_abs = 0.0, median_abs = 0.0, p95_abs = 0.0, std_abs = 0.0;
};

// Of no values: all NaN, so that nothing is taken for a perfect result. One NaN among the values makes all
// NaN.
Summary summarise(const std::vector<double>& values) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sizes(values.size());
  std::transform(values.begin(), values.end(), sizes.begin(), [](double v) { return std::fabs(v); });
  if (sizes.empty() || std::any_of(sizes.begin(), sizes.end(), [](double v) { return std::isnan(v); })) {
    return {nan, nan, nan, nan, nan, nan};
  }
  const double n = static_cast<double>(sizes.size());
  Summary s;
  for (const double v : sizes) {
    s.mean_abs += v / n;
    s.rmse += v * v / n;
  }
  for (const double v : sizes) s.std_abs += (v - s.mean_abs) * (v - s.mean_abs) / n;
  s.rmse = std::sqrt(s.rmse);
  s.std_abs = std::sqrt(s.std_abs);
  std::sort(sizes.begin(), sizes.end());
  s.max_abs = sizes.back();
  s.median_abs = interpolated_quantile(sizes, 0.5);
  s.p95_abs = interpolated_quantile(sizes, 0.95);
  return s;
}

Relation read_relation(Fields& fields) {
  constexpr double kMaxStampS = 1e12, kMaxM = 1e8, kMaxRad = 1e6;
  Relation relation;
  relation.stamp_1_s = fields.bounded("a time stamp", kMaxStampS);
  relation.stamp_2_s = fields.bounded("a time stamp", kMaxStampS);
  relation.delta.x_m = fields.bounded("a finite translation", kMaxM);
  relation.delta.y_m = fields.bounded("a finite translation", kMaxM);
  fields.bounded("a finite translation", kMaxM);
  fields.bounded("a finite rotation", kMaxRad);
  fields.bounded("a finite rotation", kMaxRad);
  relation.delta.theta_rad = wrap64(fields.bounded("a finite rotation", kMaxRad));
  if (!fields.empty()) fields.fail("8 numbers: t1 t2 dx dy dz roll pitch yaw");
  return relation;
}

}  // namespace

TrackErrors compare_tracks(const Trajectory& estimate, const Trajectory& truth, double max_gap_s) {
  const Truth true_pose(truth, max_gap_s);
  TrackErrors e;
  for (const auto& [stamp_s, pose] : estimate) {
    const std::optional<Pose> reference = true_pose.at(stamp_s);
    if (!reference) {
      ++e.without_truth;
      continue;
    }
    ++e.compared;
    e.stamp_s.push_back(stamp_s);
    e.x_error_m.push_back(pose.x_m - reference->x_m);
    e.y_error_m.push_back(pose.y_m - reference->y_m);
    e.position_error_m.push_back(std::hypot(e.x_error_m.back(), e.y_error_m.back()));
    e.heading_error_rad.push_back(wrap64(pose.theta_rad - reference->theta_rad));
  }
  const Summary position = summarise(e.position_error_m);
  const Summary heading = summarise(e.heading_error_rad);
  e.position_rmse_m = position.rmse;
  e.position_mae_m = position.mean_abs;
  e.position_max_m = position.max_abs;
  e.position_p95_m = position.p95_abs;
  e.heading_rmse_rad = heading.rmse;
  e.heading_mae_rad = heading.mean_abs;
  e.heading_max_rad = heading.max_abs;
  e.x_rmse_m = summarise(e.x_error_m).rmse;
  e.y_rmse_m = summarise(e.y_error_m).rmse;
  return e;
}

std::vector<std::optional<Pose>> truth_at(const Trajectory& truth, const std::vector<double>& stamps_s,
                                          double max_gap_s) {
  const Truth true_pose(truth, max_gap_s);
  std::vector<std::optional<Pose>> poses;
  for (const double stamp_s : stamps_s) poses.push_back(true_pose.at(stamp_s));
  return poses;
}

std::vector<Relation> read_relations(const std::string& path) {
  LineReader lines = LineReader::from_file(path);
  std::vector<Relation> relations = read_text_rows(lines, read_relation);
  if (relations.empty()) throw input_error(path, 0, "expected a relation, found none");
  return relations;
}

RelationErrors compare_relations(const Trajectory& estimate, const std::vector<Relation>& relations) {
  const StampIndex pose_at(estimate);
  RelationErrors e;
  e.repeated_stamps = estimate.size() - pose_at.size();
  std::vector<double> translations_m, rotations_rad;
  for (const Relation& relation : relations) {
    const Pose* pose_1 = pose_at.find(relation.stamp_1_s);
    const Pose* pose_2 = pose_at.find(relation.stamp_2_s);
    if (pose_1 == nullptr || pose_2 == nullptr) {
      ++e.without_pose;
      continue;
    }
    ++e.compared;
    const Pose error = relative(relative(*pose_2, *pose_1), relation.delta);
    translations_m.push_back(std::hypot(error.x_m, error.y_m));
    rotations_rad.push_back(std::fabs(error.theta_rad));
    e.each.push_back({relation.stamp_1_s, relation.stamp_2_s, *pose_1, *pose_2, translations_m.back(),
                      rotations_rad.back()});
  }
  const Summary translation = summarise(translations_m);
  e.translation_mean_m = translation.mean_abs;
  e.translation_std_m = translation.std_abs;
  e.translation_rmse_m = translation.rmse;
  e.translation_median_m = translation.median_abs;
  e.translation_max_m = translation.max_abs;
  const Summary rotation = summarise(rotations_rad);
  e.rotation_mean_rad = rotation.mean_abs;
  e.rotation_std_rad = rotation.std_abs;
  e.rotation_rmse_rad = rotation.rmse;
  e.rotation_median_rad = rotation.median_abs;
  e.rotation_max_rad = rotation.max_abs;
  return e;
}

}  // namespace parloc
