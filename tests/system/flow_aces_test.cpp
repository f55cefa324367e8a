// The recorded drive through ACES (PARLOC_DATA): quick turns between scans, two gaps of seconds, and walls
// all around. A filter that takes the far beams of a scan for a reason to go farther, or steps beyond the
// reach of the field, is lost here for good.
#include <gtest/gtest.h>

#include <ostream>

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/eval/metrics.h"
#include "common/io/log.h"
#include "common/map/map_reader.h"
#include "tests/unit/real_data.h"

namespace parloc {
namespace {

struct Case {
  const char* name;
  std::uint64_t seed;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name << " seed " << c.seed;
}

class FlowAces : public testing::TestWithParam<Case> {};

TEST_P(FlowAces, IsFollowedToTheEnd) {
  const std::string folder = "aces/";
  PARLOC_NEEDS_FILE(test::real_data(folder + "scans.log"));
  const Trajectory truth = read_tum(test::real_data(folder + "reference.tum"));
  Config config;
  config.particles = 100;
  config.seed = GetParam().seed;
  config.backend = BackendChoice::cpu;
  const auto filter =
      make_pose_filter(GetParam().name, config, read_map(test::real_data(folder + "map.yaml")));
  const auto log = open_carmen_log(test::real_data(folder + "scans.log"));
  Trajectory track;
  for (LogRecord r; log->next(r);) {
    if (r.kind != RecordKind::scan || r.stamp_s < truth.front().stamp_s) continue;
    if (track.empty()) filter->start_at(truth.front().pose, 0.1, 0.1, 0.05);
    track.push_back({r.stamp_s, filter->step(r.odometry, r.scan).pose});
  }
  const TrackErrors e = compare_tracks(track, truth);
  EXPECT_EQ(e.compared, 7374u);
  // The reference is itself 3 to 6 cm off. Measured: 0.055 m (ekf) and 0.051 m, at most 0.44 m for a scan
  // after a gap.
  EXPECT_LT(e.position_mae_m, 0.07);
  EXPECT_LT(e.position_max_m, 0.7);
}

// naedh was lost with seed 4, ekf (without random numbers) always.
INSTANTIATE_TEST_SUITE_P(All, FlowAces, testing::Values(Case{"ekf", 1}, Case{"naedh", 1}, Case{"naedh", 4}),
                         [](const auto& one) {
                           return one.param.name + std::string("_seed_") + std::to_string(one.param.seed);
                         });

}  // namespace
}  // namespace parloc
