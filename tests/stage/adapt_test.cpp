// The stage that chooses the number of particles: known answers of its bound, the parallel forms of both
// backends against the loop that draws one candidate after the other, and whole steps with a number that goes
// up and down.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <random>
#include <set>

#include "common/filter/bind.h"
#include "common/filter/start.h"
#include "common/math/normal_quantile.h"
#include "cpu/simd.h"
#include "cpu/stages.h"
#include "cuda/stages.h"

namespace {
std::atomic<std::size_t> allocations{0};
}
// Of the whole program, to count them. Not inlined: gcc would take free() for a mistake.
__attribute__((noinline)) void* operator new(std::size_t size) {
  ++allocations;
  void* p = std::malloc(size > 0 ? size : 1);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
__attribute__((noinline)) void operator delete(void* p) noexcept {
  std::free(p);
}
__attribute__((noinline)) void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<Backend> make_backend_on_host(const BackendConfig& config);
}
namespace {

// SPEC 6.1's table of n(k).
TEST(Kld, TheBoundIsFoxs) {
  const std::uint64_t bins[] = {2, 3, 5, 10, 20, 50, 100, 200, 500, 1000};
  struct Row {
    double pf_err, z;
    double particles[10];
  };
  const Row rows[] = {{0.05, 2.3263478740, {66, 93, 134, 217, 363, 750, 1347, 2484, 5755, 11060}},
                      {0.05, 0.99, {20, 37, 66, 131, 250, 588, 1129, 2188, 5303, 10433}},
                      {0.01, 3, {527, 674, 901, 1363, 2150, 4208, 7332, 13213, 29958, 56923}},
                      {0.02, 0.99, {49, 91, 164, 326, 625, 1468, 2822, 5468, 13256, 26081}}};
  for (const Row& row : rows)
    for (std::size_t k = 0; k < 10; ++k) EXPECT_EQ(kld_bound(bins[k], row.pf_err, row.z), row.particles[k]);
}

TEST(Kld, LimitsHoldAndOneBinNeedsTheFewest) {
  const KldRule rule = bind_kld({}, 100, 1000);
  EXPECT_EQ(kld_needed(rule, 0), 100u);
  EXPECT_EQ(kld_needed(rule, 1), 100u);
  EXPECT_EQ(kld_needed(rule, 2), 100u);
  EXPECT_EQ(kld_needed(rule, 10), 217u);
  EXPECT_EQ(kld_needed(rule, 500), 1000u);
}

// The loop relies on it: more bins never need fewer particles, for every quantile that may be configured.
TEST(Kld, TheBoundGrowsWithTheBins) {
  for (const double z : {0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 4.76, 5.0})
    for (std::uint64_t k = 2; k < 5000; ++k)
      ASSERT_LE(kld_bound(k, 0.05, z), kld_bound(k + 1, 0.05, z)) << z << " " << k;
}

TEST(Kld, DeltaAndPfZAreTwoWaysToSayTheSame) {
  KldConfig c;
  EXPECT_NEAR(bind_kld(c, 1, 2).z, 2.3263478740408408, 1e-14);
  c.pf_z = 0.99;
  EXPECT_EQ(bind_kld(c, 1, 2).z, 0.99);
}

// Python's statistics.NormalDist().inv_cdf, which is the same algorithm, and symmetry.
TEST(Kld, NormalQuantiles) {
  const double known[][2] = {{0.5, 0.0},
                             {0.6, 0.2533471031357998},
                             {0.84, 0.994457883209753},
                             {0.95, 1.6448536269514715},
                             {0.99, 2.3263478740408408},
                             {0.999, 3.0902323061678132},
                             {0.999999, 4.753424308822899}};
  for (const auto& [p, z] : known) {
    EXPECT_NEAR(normal_quantile(p), z, 1e-11 + 1e-14 * z);  // 1 - p loses digits in the tail
    EXPECT_NEAR(normal_quantile(1.0 - p), -z, 1e-10);
  }
}

TEST(Kld, BinsOfHeadingGoRoundAndTouchNoNeighbourInX) {
  KldConfig c;
  c.bin_size_xy = 0.25;
  c.bin_size_theta = 0.5;  // 2 pi / 0.5 = 12.57: 13 bins
  const KldRule rule = bind_kld(c, 1, 2);
  EXPECT_EQ(rule.heading_bins, 13);
  std::set<std::uint64_t> bins;
  for (int k = 0; k < 1000; ++k)
    bins.insert(kld_bin(rule, {0.1f, 0.1f, wrap(static_cast<float>(k) * 0.0062832f)}));
  EXPECT_EQ(bins.size(), 13u);
  EXPECT_EQ(kld_bin(rule, {0.01f, 0.24f, 0.0f}), kld_bin(rule, {0.24f, 0.01f, 0.0f}));
  EXPECT_NE(kld_bin(rule, {-0.01f, 0.1f, 0.0f}), kld_bin(rule, {0.01f, 0.1f, 0.0f}));
  EXPECT_NE(kld_bin(rule, {0.26f, 0.1f, 0.0f}), kld_bin(rule, {0.24f, 0.1f, 0.0f}));
}

// ---- parallel forms ----------------------------------------------------------------------------------

/// Weighted particles, and everything that the stage needs besides.
struct Scene {
  std::vector<float> x, y, theta;
  std::vector<std::uint64_t> cumulative;
  std::vector<std::uint32_t> free = {5, 17, 18, 900};
  std::uint32_t count, to_count = 0;
  StepState state;
  KldRule rule;
  RandomKey key;

  /// `spread_m`: 0 puts all into one bin.
  Scene(std::uint32_t particles, float spread_m, std::uint32_t fewest, std::uint32_t most, unsigned seed)
      : count(particles) {
    std::mt19937 random(seed);  // the standard says which numbers it gives
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    std::uint64_t total = 0;
    for (std::uint32_t i = 0; i < particles; ++i) {
      x.push_back(3.1f + spread_m * unit());
      y.push_back(2.1f + spread_m * unit());
      theta.push_back(wrap(spread_m * unit()));
      const std::uint64_t w = random() % 3 == 0 ? 0 : random() % (1u << (random() % 30 + 1));
      cumulative.push_back(total += w);
    }
    cumulative.back() = ++total;
    state.total = total;
    state.resample = 1;
    rule = bind_kld({}, fewest, most);
    key = {seed * 977ull, seed % 13};
  }
  AdaptArgs args(BinTable bins, std::uint64_t* first) {
    const FreeSpace free_space{free.data(), 4, 100, 0.05f};
    return {{x.data(), y.data(), theta.data(), nullptr, &count, rule.most},
            {nullptr, nullptr, nullptr, nullptr, &to_count, rule.most},
            {nullptr, cumulative.data()},
            rule,
            free_space,
            key,
            bins,
            &state,
            first};
  }
};

/// A table in host memory; every use must leave it as it was.
struct Table {
  explicit Table(std::uint32_t most)
      : capacity(bin_capacity(most)),
        key(capacity, kNoBin),
        weight(capacity),
        parent(capacity),
        slot(most),
        used(most) {
    for (std::uint32_t s = 0; s < capacity; ++s) parent[s] = s;
  }
  BinTable view() {
    return {key.data(), weight.data(), parent.data(), slot.data(), used.data(), &count, capacity};
  }
  bool empty() const {
    for (std::uint32_t s = 0; s < capacity; ++s)
      if (key[s] != kNoBin || weight[s] != 0 || parent[s] != s) return false;
    return count == 0;
  }
  std::uint32_t capacity;
  std::vector<std::uint64_t> key, weight;
  std::vector<std::uint32_t> parent, slot, used;
  std::uint64_t count = 0;
};

/// Draws one candidate after the other and stops at the first that makes them enough (Fox 2003, table 1).
std::uint32_t one_by_one(const AdaptArgs& a) {
  std::set<std::uint64_t> bins;
  for (std::uint32_t j = 1; j < a.rule.most; ++j) {
    bins.insert(candidate_bin(a, j - 1));
    if (j >= kld_needed(a.rule, bins.size())) return j;
  }
  return a.rule.most;
}

struct Found {
  std::uint32_t loop, cpu, kernels;
};

Found find(Scene& scene, int threads) {
  Table table(scene.rule.most);
  std::vector<std::uint64_t> first(scene.rule.most);
  const AdaptArgs args = scene.args(table.view(), first.data());
  Found found{};
  found.loop = one_by_one(args);

  cpu::Workers workers;
  workers.threads = threads;
  cpu::adapt(args, workers);
  found.cpu = scene.to_count;
  EXPECT_EQ(scene.state.next_count, scene.to_count);
  EXPECT_TRUE(table.empty());

  scene.to_count = scene.state.next_count = 0;
  cuda_on_host::StepInput input;
  input.key = scene.key;
  cuda_on_host::Scratch scratch;
  scratch.reserve(scene.rule.most);
  AdaptArgs without_key = args;
  without_key.key = {};  // the kernels have it from the input
  cuda_on_host::adapt(without_key, &input, scratch, nullptr);
  found.kernels = scene.to_count;
  EXPECT_EQ(scene.state.next_count, scene.to_count);
  EXPECT_TRUE(table.empty());
  return found;
}

TEST(Adapt, BothFormsStopWhereTheLoopDoes) {
  std::size_t capped = 0, fewest = 0, between = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const std::uint32_t most = seed % 3 == 0 ? 400 : 5000;
    const float spread_m =
        seed % 7 == 0 ? 0.0f : 0.2f * static_cast<float>(seed % 11) * static_cast<float>(seed % 5);
    Scene scene(1 + seed * 7 % 2000, spread_m, 1 + seed * 31 % 120, most, seed);
    if (seed % 4 == 0) scene.state.inject = 0.1;
    const Found n = find(scene, 1 + static_cast<int>(seed % 3));
    ASSERT_EQ(n.cpu, n.loop) << seed;
    ASSERT_EQ(n.kernels, n.loop) << seed;
    capped += n.loop == most ? 1 : 0;
    fewest += n.loop == scene.rule.fewest ? 1 : 0;
    between += n.loop != most && n.loop != scene.rule.fewest ? 1 : 0;
  }
  // All three ends of the loop were met, or this test shows little.
  EXPECT_GT(capped, 20u);
  EXPECT_GT(fewest, 20u);
  EXPECT_GT(between, 100u);
}

TEST(Adapt, ManyThreadsFindTheSame) {
  Scene scene(15000, 9.0f, 10, 20000, 5);
  const Found n = find(scene, 4);
  EXPECT_EQ(n.cpu, n.loop);
  EXPECT_EQ(n.kernels, n.loop);
  EXPECT_GT(n.loop, 8192u);  // fewer would not be shared out
}

TEST(Adapt, WithoutResamplingTheNumberStays) {
  Scene scene(123, 3.0f, 10, 1000, 5);
  scene.state.resample = 0;
  const Found n = find(scene, 1);
  EXPECT_EQ(n.cpu, 123u);
  EXPECT_EQ(n.kernels, 123u);
}

// ---- whole steps -------------------------------------------------------------------------------------

GridMap room() {
  std::vector<std::string> rows(60, std::string(110, '.'));
  for (std::size_t i = 0; i < 110; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  for (std::size_t k = 0; k < 14; ++k) rows[5 + k * 3][(k * 37) % 100 + 4] = '#';
  return grid_from_text(rows, 0.05, {-1.0, 2.0, 0.3});
}

/// What a LiDAR sees; every fourth step it is another place's, so that the likelihood goes up and down.
Scan fan(std::size_t step) {
  Scan s;
  s.angle_min_rad = -2.0;
  s.angle_step_rad = 0.05;
  s.range_max_m = 4.0;
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

Steps run(Backend& backend, const BackendConfig& config, std::int64_t start) {
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

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

void expect_same(const Steps& a, const Steps& b) {
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k));
    const StepState &s = a.states[k], &u = b.states[k];
    ASSERT_EQ(s.count, u.count);
    ASSERT_EQ(s.next_count, u.next_count);
    EXPECT_TRUE(same_bits(a.sets[k].x, b.sets[k].x));
    EXPECT_TRUE(same_bits(a.sets[k].y, b.sets[k].y));
    EXPECT_TRUE(same_bits(a.sets[k].theta, b.sets[k].theta));
    EXPECT_TRUE(same_bits(a.sets[k].log_weight, b.sets[k].log_weight));
    EXPECT_EQ(a.weights[k], b.weights[k]);
    EXPECT_EQ(a.cumulative[k], b.cumulative[k]);
    EXPECT_EQ(a.ancestors[k], b.ancestors[k]);
    EXPECT_EQ(s.total, u.total);
    EXPECT_EQ(s.n_eff, u.n_eff);
    EXPECT_EQ(s.inject, u.inject);
    EXPECT_EQ(s.likelihood.scan, u.likelihood.scan);
    EXPECT_EQ(s.likelihood.slow, u.likelihood.slow);
    EXPECT_EQ(s.likelihood.fast, u.likelihood.fast);
    EXPECT_EQ(std::memcmp(&s.all, &u.all, sizeof s.all), 0);
    EXPECT_EQ(std::memcmp(&s.cluster, &u.cluster, sizeof s.cluster), 0);
  }
}

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
  BackendConfig config(int threads) const {
    BackendConfig c;
    c.particles = GetParam().most;
    c.min_particles = GetParam().fewest;
    c.threads = threads;
    c.sensor = default_sensor(GetParam().model);
    c.resample.scheme = GetParam().scheme;
    c.resample.threshold = 0.9;
    c.kld.pf_err = GetParam().pf_err;
    if (GetParam().recovery)
      c.recovery.recovery_alpha_slow = 0.05, c.recovery.recovery_alpha_fast = 0.6,
      c.recovery.recovery_margin = 1.0;
    return c;
  }
  Steps cpu(std::int64_t start, int threads) const {
    return run(*make_cpu_backend(config(threads)), config(threads), start);
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
TEST_P(AdaptiveSteps, KernelBodiesOnTheHostEqualTheOpenMpTwin) {
  for (const std::int64_t start : starts()) {
    SCOPED_TRACE(start);
    const auto kernels = cuda_on_host::make_backend_on_host(config(1));
    expect_same(cpu(start, 1), run(*kernels, config(1), start));
  }
}

TEST_P(AdaptiveSteps, ThreadsDoNotMatter) {
  for (const std::int64_t start : starts()) {
    SCOPED_TRACE(start);
    const Steps one = cpu(start, 1);
    expect_same(one, cpu(start, 2));
    expect_same(one, cpu(start, 4));
  }
}

TEST_P(AdaptiveSteps, InstructionSetDoesNotMatter) {
  const Steps best = cpu(GetParam().most, 2);
  for (const cpu::Simd level : {cpu::Simd::avx2, cpu::Simd::baseline}) {
    cpu::limit_simd(level);
    expect_same(best, cpu(GetParam().most, 2));
  }
  cpu::limit_simd(cpu::Simd::avx512);
}

TEST_P(AdaptiveSteps, GpuEqualsCpu) {
  std::unique_ptr<Backend> gpu;
  try {
    std::string why;
    gpu = make_backend(BackendChoice::cuda, config(1), why);
  } catch (const Error& e) {
    const char* required = std::getenv("PARLOC_REQUIRE_GPU");
    if (required != nullptr && std::strcmp(required, "1") == 0) FAIL() << e.what();
    GTEST_SKIP() << e.what();
  }
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
  BackendConfig c;
  c.particles = 20000;
  c.min_particles = 10;
  c.threads = 1;  // a team of threads is the OpenMP library's
  c.resample.threshold = 1.0;
  c.recovery.recovery_alpha_slow = 0.05, c.recovery.recovery_alpha_fast = 0.6,
  c.recovery.recovery_margin = 1.0;
  const GridMap map = room();
  const auto backend = make_cpu_backend(c);
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
    if (step == 1) before = allocations;
    backend->predict({0.05f, 0.1f, -0.02f, 0.02f, 0.05f, 0.02f}, {99, step});
    backend->set_scan(beams[step]);
    backend->weight(true);
    backend->normalise_scan();
    backend->estimate();
    backend->adapt({99, step}, step % 8 == 4);
    backend->resample({99, step});
    most = std::max(most, backend->finish().next_count);
  }
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_EQ(most, 20000u);
}

// A number that may not change and one that need not are the same filter.
TEST(AdaptiveSteps, NothingElseChangesWithTheCapacity) {
  BackendConfig small, large;
  small.particles = 700;
  large.particles = 5000;  // both below 2^22 particles: weights have the same bits
  expect_same(run(*make_cpu_backend(small), small, 700), run(*make_cpu_backend(large), large, 700));
  const auto kernels = cuda_on_host::make_backend_on_host(large);
  expect_same(run(*make_cpu_backend(small), small, 700), run(*kernels, large, 700));
}

}  // namespace
}  // namespace parloc
