// Whole steps with a number of particles that goes up and down: every array follows, and the kernel bodies
// run on the host, the OpenMP loops and a GPU where there is one agree to the bit.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/filter/filter_backend.h"
#include "common/filter/start.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<FilterBackend> make_filter_backend_on_host(const FilterBackendConfig& config);
}
namespace {

GridMap room() {
  return test::room_of_blocks(test::rows_with_blocks());
}

/// What a LiDAR sees; every fourth step it is another place's, so that the likelihood goes up and down.
Scan fan(std::size_t step) {
  Scan s{.angle_min_rad = -2.0, .angle_step_rad = 0.05, .range_max_m = 4.0};
  for (std::size_t i = 0; i < 80; ++i)
    s.ranges_m.push_back(0.4f + 0.013f * static_cast<float>((i * (step % 4 == 3 ? 29 : 3)) % 200));
  return s;
}

struct Steps {
  std::vector<StepState> states;
  std::vector<ParticleSet> sets;
  std::vector<std::vector<std::uint64_t>> weights, cumulative;
  std::vector<std::vector<std::uint32_t>> ancestors;
};

Steps run(FilterBackend& backend, const FilterBackendConfig& config, std::int64_t start) {
  const GridMap map = room();
  backend.set_map(map);
  backend.upload(uniform_start(map, start, 7));
  BeamTable beams;
  BeamCounts counts;
  Steps t;
  for (std::uint32_t step = 0; step < 16; ++step) {
    select_beams(fan(step), ScanConfig{}, config.sensor, map.resolution_m, beams, counts);
    if (step == 0) backend.set_range_max(beams.range_max_m);
    const RandomKey key{99, step};
    MotionStep motion{0.05f, 0.1f, -0.02f, 0.02f, 0.05f, 0.02f};
    if (step % 5 == 4) motion.spread_xy = 0.4f, motion.spread_theta = 0.2f;
    backend.predict(motion, key);
    if (step != 9) {  // one step is prediction only
      backend.set_scan(beams);
      backend.weight(true);
    }
    backend.normalise_scan();
    backend.estimate();
    if (step != 9) {
      backend.adapt(key, step % 7 == 3);
      backend.resample(key);
    }
    t.states.push_back(backend.finish());
    t.sets.push_back(backend.download());
    t.weights.push_back(backend.weights());
    t.cumulative.push_back(backend.cumulative());
    t.ancestors.push_back(backend.ancestors());
  }
  return t;
}

void expect_same(const Steps& a, const Steps& b) {
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k));
    const StepState &s = a.states[k], &u = b.states[k];
    ASSERT_EQ(s.count, u.count);
    ASSERT_EQ(s.next_count, u.next_count);
    test::expect_same_bits(a.sets[k], b.sets[k]);
    EXPECT_EQ(a.weights[k], b.weights[k]);
    EXPECT_EQ(a.cumulative[k], b.cumulative[k]);
    EXPECT_EQ(a.ancestors[k], b.ancestors[k]);
    EXPECT_EQ(s.total, u.total);
    EXPECT_EQ(s.n_eff, u.n_eff);
    EXPECT_EQ(s.inject, u.inject);
    EXPECT_EQ(s.likelihood.scan, u.likelihood.scan);
    EXPECT_EQ(s.likelihood.slow, u.likelihood.slow);
    EXPECT_EQ(s.likelihood.fast, u.likelihood.fast);
    EXPECT_TRUE(test::same_bits(s.all, u.all));
    EXPECT_TRUE(test::same_bits(s.cluster, u.cluster));
  }
}

constexpr RecoveryConfig kQuickRecovery{
    .recovery_alpha_slow = 0.05, .recovery_alpha_fast = 0.6, .recovery_margin = 1.0};

struct Case {
  SensorModel model;
  ResampleScheme scheme;
  std::int64_t most, fewest;
  double pf_err;
  bool recovery;
  const char* name;
};

class AdaptiveSteps : public testing::TestWithParam<Case> {
 protected:
  FilterBackendConfig config(int threads) const {
    FilterBackendConfig c;
    c.particles = GetParam().most;
    c.min_particles = GetParam().fewest;
    c.threads = threads;
    c.sensor = default_sensor(GetParam().model);
    c.resample.scheme = GetParam().scheme;
    c.resample.threshold = 0.9;
    c.kld.pf_err = GetParam().pf_err;
    if (GetParam().recovery) c.recovery = kQuickRecovery;
    return c;
  }
  Steps cpu(std::int64_t start, int threads) const {
    return run(*make_cpu_filter_backend(config(threads)), config(threads), start);
  }
  /// Around the edges of warps and blocks, and all that there can be.
  std::vector<std::int64_t> starts() const {
    std::vector<std::int64_t> s;
    for (const std::int64_t n : {1, 31, 32, 33, 257, 1024, 1025})
      if (n <= GetParam().most) s.push_back(n);
    if (s.back() != GetParam().most) s.push_back(GetParam().most);
    return s;
  }
};

TEST_P(AdaptiveSteps, TheNumberGoesUpAndDownAndEveryArrayFollows) {
  bool up = false, down = false;
  for (const std::int64_t start : starts()) {
    const Steps t = cpu(start, 1);
    for (std::size_t k = 0; k < t.states.size(); ++k) {
      const StepState& s = t.states[k];
      EXPECT_EQ(s.count, k == 0 ? static_cast<std::uint32_t>(start) : t.states[k - 1].next_count);
      EXPECT_EQ(t.weights[k].size(), s.count);
      if (k == 9) continue;  // nothing was drawn
      EXPECT_EQ(t.cumulative[k].back(), s.total);
      EXPECT_EQ(t.sets[k].x.size(), s.next_count);
      EXPECT_EQ(t.ancestors[k].size(), s.next_count);
      for (const std::uint32_t from : t.ancestors[k])
        EXPECT_TRUE(from < s.count || (from == 0xffffffffu && s.inject > 0.0));
      EXPECT_GE(s.next_count, std::min<std::int64_t>(s.count, GetParam().fewest));
      EXPECT_LE(s.next_count, GetParam().most);
      up = up || s.next_count > s.count;
      down = down || s.next_count < s.count;
    }
  }
  EXPECT_TRUE(up);
  EXPECT_TRUE(down);
}

// Steps are recorded and started again with other numbers: an argument that holds a number would show.
TEST_P(AdaptiveSteps, KernelBodiesOnTheHostAndAnyNumberOfThreadsAgree) {
  for (const std::int64_t start : starts()) {
    SCOPED_TRACE(start);
    const Steps one = cpu(start, 1);
    const auto kernels = cuda_on_host::make_filter_backend_on_host(config(1));
    expect_same(one, run(*kernels, config(1), start));
    expect_same(one, cpu(start, 2));
    expect_same(one, cpu(start, 4));
  }
}

TEST_P(AdaptiveSteps, InstructionSetDoesNotMatter) {
  const Steps best = cpu(GetParam().most, 2);
  for (const cpu::Simd level : {cpu::Simd::avx2, cpu::Simd::baseline}) {
    const test::SimdLimit limit(level);
    expect_same(best, cpu(GetParam().most, 2));
  }
}

TEST_P(AdaptiveSteps, GpuEqualsCpu) {
  std::unique_ptr<FilterBackend> gpu;
  std::string why;
  PARLOC_NEEDS_GPU(gpu = make_filter_backend(BackendChoice::cuda, config(1), why));
  for (const std::int64_t start : starts()) {
    SCOPED_TRACE(start);
    expect_same(cpu(start, 2), run(*gpu, config(1), start));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, AdaptiveSteps,
    testing::Values(
        Case{SensorModel::likelihood_field, ResampleScheme::systematic, 3000, 20, 0.05, true, "field"},
        Case{SensorModel::likelihood_field, ResampleScheme::residual, 2500, 5, 0.1, true, "residual"},
        Case{SensorModel::beam, ResampleScheme::stratified, 1100, 8, 0.1, false, "beam"},
        Case{SensorModel::class_conditional, ResampleScheme::multinomial, 600, 2, 0.4, true,
             "class_conditional"},
        Case{SensorModel::likelihood_field_prob, ResampleScheme::systematic, 12000, 5, 0.02, false, "many"}),
    [](const auto& one) { return std::string(one.param.name); });

// From the second step on, though the number goes up later than that.
TEST(AdaptiveSteps, NothingIsAllocatedInAStep) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const FilterBackendConfig c{.particles = 20000,
                              .threads = 1,  // a team of threads is the OpenMP library's
                              .resample = {.threshold = 1.0},
                              .min_particles = 10,
                              .recovery = kQuickRecovery};
  const GridMap map = room();
  const auto backend = make_cpu_filter_backend(c);
  backend->set_map(map);
  backend->upload(uniform_start(map, 50, 7));
  std::vector<BeamTable> beams(16);
  BeamCounts counts;
  for (std::uint32_t k = 0; k < 16; ++k)
    select_beams(fan(k), ScanConfig{}, c.sensor, map.resolution_m, beams[k], counts);
  backend->set_range_max(beams[0].range_max_m);
  std::size_t before = 0;
  std::uint32_t most = 0;
  for (std::uint32_t step = 0; step < 16; ++step) {
    if (step == 1) before = test::allocations();
    backend->predict({0.05f, 0.1f, -0.02f, 0.02f, 0.05f, 0.02f}, {99, step});
    backend->set_scan(beams[step]);
    backend->weight(true);
    backend->normalise_scan();
    backend->estimate();
    backend->adapt({99, step}, step % 8 == 4);
    backend->resample({99, step});
    most = std::max(most, backend->finish().next_count);
  }
  EXPECT_EQ(test::allocations() - before, 0u);
  EXPECT_EQ(most, 20000u);
}

// A number that may not change and one that need not are the same filter.
TEST(AdaptiveSteps, NothingElseChangesWithTheCapacity) {
  // Both below 2^22 particles: weights have the same bits.
  const FilterBackendConfig small{.particles = 700}, large{.particles = 5000};
  expect_same(run(*make_cpu_filter_backend(small), small, 700),
              run(*make_cpu_filter_backend(large), large, 700));
  const auto kernels = cuda_on_host::make_filter_backend_on_host(large);
  expect_same(run(*make_cpu_filter_backend(small), small, 700), run(*kernels, large, 700));
}

}  // namespace
}  // namespace parloc
