// Same seed, same map, for grid SLAM: whole runs on a real log, and around a simulated ring whose loop is
// closed, have pinned digests at any thread count and with any instruction set (docs/determinism.md).
#include <gtest/gtest.h>

#include <ostream>

#include "common/slam/grid_slam.h"
#include "tests/system/golden_corridor.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/ring_drive.h"
#include "tests/unit/without_gpu.h"

namespace parloc::test {
namespace {

struct Golden {
  const char* name;
  SlamProposal proposal;
  bool search;  ///< A window before the climb.
  const char* digest;
};

void PrintTo(const Golden& g, std::ostream* out) {
  *out << g.name;
}

/// Every setting that it reads is written out: a changed default must not change a golden digest.
GridSlamConfig fixed_config(const Golden& golden) {
  const SlamProposal proposal = golden.proposal;
  GridSlamConfig c;
  c.seed = 42;
  c.backend = BackendChoice::cpu;
  c.device = 0;
  c.motion = kGoldenMotion;
  c.scan.min_beams = 5, c.scan.laser_min_range = 0.1, c.scan.laser_max_range = 40.0;
  c.scan.zero_policy = ZeroPolicy::invalid;
  c.slam = {.particles = golden.search ? 5 : 20,
            .proposal = proposal,
            .resolution = 0.1,
            .usable_range = 25.0,
            .resample_threshold = 0.7,
            .beta_weight = proposal == SlamProposal::motion ? 0.005 : 0.05,
            .beta_proposal = 1.0,
            .search_xy = golden.search ? 0.3 : 0.0,
            .search_theta = golden.search ? 0.1 : 0.0,
            .search_bias = 0.25,
            .step_xy = 0.1,
            .step_theta = 0.05,
            .iterations = 6,
            .sigma_score = 0.02,
            .sigma_likelihood = 0.075,
            .min_score = 0.1,
            .box_xy = 0.06,
            .box_theta = 0.04,
            .motion_floor_xy = 0.02,
            .motion_floor_theta = 0.005,
            .occupied_above = 0.25,
            .close_loops = false};
  c.scan.max_beams = 120;
  c.update_min_d = 0.3;
  c.update_min_a = 0.2;
  return c;
}

void run_corridor(GridSlam& slam) {
  const auto log = corridor_log();
  for (LogRecord r; log->next(r);)
    if (r.kind == RecordKind::scan) slam.step(r.odometry, r.scan);
}

class SlamDigest : public testing::TestWithParam<Golden> {};

TEST_P(SlamDigest, OfARealLogIsPinned) {
  for (const cpu::Simd set : instruction_sets()) {
    const SimdLimit limit(set);
    for (const int threads : {1, 2, 4}) {
      GridSlamConfig c = fixed_config(GetParam());
      c.threads = threads;
      GridSlam slam(c);
      run_corridor(slam);
      EXPECT_EQ(slam.digest(), GetParam().digest) << slam.backend_name();
    }
  }
}

// Worth pinning only if it kept track, resampled, but not always, and left scans out.
TEST_P(SlamDigest, TheRunIsWorthPinning) {
  GridSlam slam(fixed_config(GetParam()));
  run_corridor(slam);
  Trajectory track = slam.trajectory();
  EXPECT_EQ(track.size(), kCorridorScans);
  for (StampedPose& p : track) p.pose = compose(kCorridorStart, p.pose);
  expect_on_track(track);
  std::size_t resampled = 0;
  for (const SlamRecord& r : slam.records()) resampled += r.resampled ? 1 : 0;
  EXPECT_GT(resampled, 2u);
  EXPECT_LT(resampled, slam.records().size() - 2);
  EXPECT_GT(slam.records().size(), 20u);
  EXPECT_LT(slam.records().size(), kCorridorScans);
}

TEST_P(SlamDigest, OfAGpuIsTheSame) {
  GridSlamConfig c = fixed_config(GetParam());
  c.backend = BackendChoice::cuda;
  std::unique_ptr<GridSlam> slam;
  PARLOC_NEEDS_GPU(slam = std::make_unique<GridSlam>(c));
  run_corridor(*slam);
  EXPECT_EQ(slam->digest(), GetParam().digest);
}

// They change with any change of the arithmetic of a step, its order included, of the matcher, or of what a
// digest holds; see tests/system/digest_test.cpp for how to renew them.
INSTANTIATE_TEST_SUITE_P(
    All, SlamDigest,
    testing::Values(Golden{"motion", SlamProposal::motion, false,
                           "70902d0c0a03ba951c7fff40a87b3c335ac74dba84d07dc097e255110f8207fd"},
                    Golden{"scan_match", SlamProposal::scan_match, false,
                           "f25df7e0aaa6b201e33987cfa1d3cff7c3380e5358aef23615ff12601eb3918c"},
                    Golden{"gaussian", SlamProposal::gaussian, false,
                           "9555a2de35b15893296dc2133e24a1f8dc975c903122a1c8c8b6f39829a818d0"},
                    Golden{"scan_match_search", SlamProposal::scan_match, true,
                           "171f8da8c33dc39252967ec916979af6333afe32904efcce8c9fe7627aa9b4e7"}),
    [](const auto& one) { return std::string(one.param.name); });

// ---- with closed loops ------------------------------------------------------------------------------------

/// Once around a ring of 16 m and 15 m more.
RingDrive round_and_more() {
  constexpr double kRadius_m = 8.0;
  const Ring ring(kRadius_m, [](int along) { return along % 37 < 3 || along % 53 < 2; });
  return noisy_drive_along(ring, 2.0 * kPi * kRadius_m + 15.0);
}

std::string digest_of_closed_loops(int threads) {
  static const RingDrive drive = round_and_more();
  GridSlamConfig c = fixed_config({"", SlamProposal::scan_match, false, ""});
  c.threads = threads;
  c.slam.particles = 1;
  c.scan.max_beams = 90;
  c.slam.resolution = 0.05;
  c.slam.usable_range = 7.0;
  c.update_min_d = c.update_min_a = 0.25;
  c.slam.step_xy = 0.05;
  c.slam.iterations = 7;
  c.slam.sigma_score = 0.01;
  c.slam.motion_floor_xy = 0.01;
  c.slam.motion_floor_theta = 0.003;
  c.slam.close_loops = true;
  const auto slam = mapped(c, drive);
  // Worth pinning only if loops were closed, and moved something.
  const LoopCounts loops = slam->loops().value();
  EXPECT_GT(loops.used, 0u);
  EXPECT_GT(loops.most_moved_m, 0.05);
  return slam->digest();
}

// It changes also with the arithmetic of the pose graph.
TEST(SlamLoopDigest, OfAClosedRingIsPinned) {
  const std::string digest = "5f7a4cf8550926f34905fdb4d76051eb1512415025f45ad06488b7eb1777ae13";
  for (const cpu::Simd set : instruction_sets()) {
    const SimdLimit limit(set);
    EXPECT_EQ(digest_of_closed_loops(1), digest);
  }
  EXPECT_EQ(digest_of_closed_loops(3), digest);
}

}  // namespace
}  // namespace parloc::test
