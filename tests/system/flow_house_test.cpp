// The recorded drive through the TurtleBot3 House (PARLOC_DATA): what the filters of the published study
// reach on it with default settings and 100 particles. The truth comes at 1 Hz and is interpolated to the
// scans, which while the robot turns is itself off by a degree: headings cannot be told better than that.
#include <gtest/gtest.h>

#include <cstdio>
#include <ostream>

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/eval/consistency.h"
#include "common/eval/metrics.h"
#include "common/io/log.h"
#include "common/map/map_reader.h"
#include "tests/unit/real_data.h"

namespace parloc {
namespace {

struct Bar {
  const char* name;
  double rmse_m, heading_rmse_rad;
  double nees = 4.0;  ///< Ideal: 3.
};

void PrintTo(const Bar& bar, std::ostream* out) {
  *out << bar.name;
}

class FlowHouse : public testing::TestWithParam<Bar> {};

/// Of the log's first scan at or after the first row of the truth.
Pose interpolated(const Trajectory& truth, double stamp_s) {
  std::size_t k = 0;
  while (k + 2 < truth.size() && truth[k + 1].stamp_s < stamp_s) ++k;
  const double part = (stamp_s - truth[k].stamp_s) / (truth[k + 1].stamp_s - truth[k].stamp_s);
  return compose(truth[k].pose, along_arc(relative(truth[k + 1].pose, truth[k].pose), part));
}

TEST_P(FlowHouse, IsLocalizedWithinTheBars) {
  const std::string folder = "tb3_house/";
  PARLOC_NEEDS_FILE(test::real_data(folder + "scans.log"));
  const Trajectory truth = read_tum(test::real_data(folder + "reference.tum"));
  Config config;
  config.particles = 100;
  config.backend = BackendChoice::cpu;
  const auto filter =
      make_pose_filter(GetParam().name, config, read_map(test::real_data(folder + "map_05.yaml")));
  const auto log = open_carmen_log(test::real_data(folder + "scans.log"));
  Trajectory track;
  std::vector<StampedCovariance> own, cloud;
  for (LogRecord r; log->next(r);) {
    if (r.kind != RecordKind::scan || r.stamp_s < truth.front().stamp_s) continue;
    if (track.empty()) filter->start_at(interpolated(truth, r.stamp_s), 0.1, 0.1, 0.05);
    const Estimate e = filter->step(r.odometry, r.scan);
    track.push_back({r.stamp_s, e.pose});
    own.push_back({r.stamp_s, e.covariance});
    cloud.push_back({r.stamp_s, e.cluster.covariance});
    EXPECT_EQ(filter->why_skipped(), "");
  }
  const TrackErrors e = compare_tracks(track, truth);
  const double nees = check_consistency(e, own).nees_mean, of_cloud = check_consistency(e, cloud).nees_mean;
  std::printf(
      "%s: %zu scans, RMSE %.4f m, MAE %.4f m, max %.3f m, heading RMSE %.4f rad, NEES %.2f (of the "
      "particles %.2f)\n",
      GetParam().name, e.compared, e.position_rmse_m, e.position_mae_m, e.position_max_m, e.heading_rmse_rad,
      nees, of_cloud);
  EXPECT_GT(e.compared, 500u);
  EXPECT_LE(e.position_rmse_m, GetParam().rmse_m);
  EXPECT_LE(e.heading_rmse_rad, GetParam().heading_rmse_rad);
  EXPECT_LE(nees, GetParam().nees);
}

INSTANTIATE_TEST_SUITE_P(All, FlowHouse,
                         testing::Values(Bar{"ekf", 0.035, 0.026}, Bar{"ekf_beams", 0.035, 0.026},
                                         Bar{"edh", 0.025, 0.022}, Bar{"naedh", 0.025, 0.022},
                                         Bar{"ledh", 0.025, 0.022}, Bar{"gromov", 0.025, 0.022},
                                         Bar{"pfpf", 0.035, 0.024, 6.0}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace parloc
