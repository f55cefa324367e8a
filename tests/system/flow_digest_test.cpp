// Same seed, same answer, for the filters on the distance field: whole runs on a real log have pinned digests
// at any thread count and with any instruction set (docs/determinism.md).
#include <gtest/gtest.h>

#include <ostream>

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "tests/system/golden_corridor.h"
#include "tests/unit/instruction_sets.h"

namespace parloc::test {
namespace {

/// Every setting that these filters read is written out: a changed default must not change a golden digest.
Config fixed_config() {
  Config c;
  c.particles = 60;
  c.seed = 42;
  c.backend = BackendChoice::cpu;
  c.motion = kGoldenMotion;
  c.scan.min_beams = 5, c.scan.laser_min_range = 0.1, c.scan.laser_max_range = 40.0;
  c.resample = {.scheme = ResampleScheme::systematic, .threshold = 0.5};
  c.flow_max_beams = 120;
  c.flow = {.steps = 6,
            .integrator = FlowIntegrator::automatic,
            .schedule = FlowSchedule::uniform,
            .ratio = 1.2,
            .prior = FlowPrior::recentred,
            .interpolation = FieldInterpolation::bilinear,
            .max_dist = 1.0,
            .sigma_range = 0.01,
            .sigma_psi_cells = 0.4,
            .gate = FlowGate::off,
            .gate_nis = 8.8,
            .z_score = 0.0,
            .map_sigma_cells = 2.0,
            .beta = 0.02,
            .iterations = 3,
            .pfpf_sigma_xy = 0.005,
            .pfpf_sigma_theta = 0.005};
  return c;
}

struct Golden {
  const char* name;
  const char* digest;
};

void PrintTo(const Golden& g, std::ostream* out) {
  *out << g.name;
}

class FlowDigest : public testing::TestWithParam<Golden> {};

TEST_P(FlowDigest, OfARealLogIsPinned) {
  for (const cpu::Simd set : instruction_sets()) {
    const SimdLimit limit(set);
    for (const int threads : {1, 2, 4}) {
      Config c = fixed_config();
      c.threads = threads;
      const auto filter = make_pose_filter(GetParam().name, c, corridor());
      filter->start_at(kCorridorStart, kCorridorSigma_m, kCorridorSigma_m, kCorridorSigma_rad);
      const auto log = corridor_log();
      Trajectory track;
      for (LogRecord r; log->next(r);)
        if (r.kind == RecordKind::scan) track.push_back({r.stamp_s, filter->step(r.odometry, r.scan).pose});
      EXPECT_EQ(filter->digest(), GetParam().digest) << filter->backend_name();
      EXPECT_EQ(filter->steps(), kCorridorScans);
      expect_on_track(track);
    }
  }
}

// They change with any change of the arithmetic of a step, its order included; see
// tests/system/digest_test.cpp for how to renew them.
INSTANTIATE_TEST_SUITE_P(
    All, FlowDigest,
    testing::Values(Golden{"ekf", "5e492cf8bcd73a695222abb9fed786d3850f9cefad21a639c0b302f2090afff1"},
                    Golden{"ekf_beams", "999b10c7587e282c1a18fbfc7ad694bb24b335d9175c9f22a5928aea816917a5"},
                    Golden{"edh", "d1c76d709fee567dd314a08b1ba7411348845bfad3e4633aa8baf0930d1a663a"},
                    Golden{"naedh", "6c63aac034ff3925e7bb9ef7b96582210a617615eef21a1c1bfe869e82f17f59"},
                    Golden{"ledh", "757342552e5579c041595e78956eb56e812497470443384005ee6bc242f5b164"},
                    Golden{"gromov", "0dd3b65a7c18dde7cff4d2d7557b122ec081ce60b468c2755edee87be28762b3"},
                    Golden{"pfpf", "e8a37a3d75f5175c82fdd257885ab7569780c610782b6fb49e019dd53472948c"}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace parloc::test
