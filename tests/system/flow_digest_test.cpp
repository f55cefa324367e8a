// Same seed, same answer, for the filters on the distance field: whole runs on a real log have pinned digests
// at any thread count and with any instruction set (docs/determinism.md).
#include <gtest/gtest.h>

#include <ostream>

#include "common/filter/pose_filter.h"
#include "tests/system/golden_corridor.h"
#include "tests/unit/instruction_sets.h"

namespace parloc::test {
namespace {

/// Every setting that these filters read is written out: a changed default must not change a golden digest.
FilterConfig fixed_config() {
  FilterConfig c;
  c.particles = 60;
  c.seed = 42;
  c.backend = BackendChoice::cpu;
  c.motion = kGoldenMotion;
  c.scan.min_beams = 5, c.scan.laser_min_range = 0.1, c.scan.laser_max_range = 40.0;
  c.resample = {.scheme = ResampleScheme::systematic, .threshold = 0.5};
  c.flow = {.max_beams = 120,
            .steps = 6,
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
      FilterConfig c = fixed_config();
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
    testing::Values(Golden{"ekf", "d83b1f32e3f0b6f4b8c7d32b9bcd60e8a429c9bbdf4914ebddc7ba3024022b6c"},
                    Golden{"ekf_beams", "999b10c7587e282c1a18fbfc7ad694bb24b335d9175c9f22a5928aea816917a5"},
                    Golden{"edh", "56034ec44895b0ce2ca2772d18ccc1eb57481f3dfd835fa9f4e616e5925a2a6d"},
                    Golden{"naedh", "26f936a147faee500ca73ccb4292c527d4fcc18fffc0dcf3a5d9b634207d3285"},
                    Golden{"ledh", "9872f112cb765072c14565705db28cdcc001f6d013456013cd532f510ede72cc"},
                    Golden{"gromov", "0dd3b65a7c18dde7cff4d2d7557b122ec081ce60b468c2755edee87be28762b3"},
                    Golden{"pfpf", "e0d97b00a39b04d9821daae083fa6b74786146ce9666ce07e59365d146557c9d"}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace parloc::test
