// Every stage, every sensor model and scheme: the kernel bodies run on the host, the OpenMP loops at several
// thread counts and instruction sets, and a GPU where there is one, all from the same input, must agree to
// the bit.
#include <gtest/gtest.h>

#include "common/filter/filter_backend.h"
#include "common/filter/start.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<FilterBackend> make_filter_backend_on_host(const FilterBackendConfig& config);
}
namespace {

using test::same_bits;

GridMap small_room() {
  std::vector<std::string> rows = test::rows_with_blocks_and_wall();
  rows[10].replace(80, 12, "????????????");
  return test::room_of_blocks(rows);
}

/// The room with a box of three walls, a slanted wall, a wall along a grid line and one that comes twice.
GridMap room_of_segments() {
  GridMap map = small_room();
  map.walls = {{0.1f, 0.1f, 5.4f, 0.1f}, {5.4f, 0.1f, 5.4f, 2.9f}, {5.4f, 2.9f, 0.1f, 2.9f},
               {0.1f, 2.9f, 0.1f, 0.1f}, {1.5f, 0.7f, 2.3f, 1.9f}, {3.0f, 1.0f, 3.0f, 2.5f},
               {3.0f, 1.0f, 3.0f, 2.5f}, {4.1f, 0.1f, 3.6f, 0.9f}};
  return map;
}

Scan fan(std::size_t beams) {
  Scan s{.T_base_sensor = {0.1, -0.05, 0.2},
         .angle_min_rad = -2.0,
         .angle_step_rad = 4.0 / static_cast<double>(beams),
         .range_max_m = 4.0};
  for (std::size_t i = 0; i < beams; ++i)
    s.ranges_m.push_back(i % 7 == 3 ? 9.0f : 0.5f + 0.013f * static_cast<float>((i * 29) % 200));
  return s;
}

/// As if the beams came from several places on the robot.
void spread_origins(BeamTable& beams) {
  for (std::size_t m = 0; m < beams.count; ++m) {
    beams.origin_x[m] += 0.02f * static_cast<float>(m % 11);
    beams.origin_y[m] -= 0.01f * static_cast<float>(m % 7);
  }
  measure_origins(beams);
}

/// Everything a backend holds after a few steps.
struct Trace {
  std::vector<float> expected_m;
  std::vector<ParticleSet> sets;
  std::vector<std::vector<std::uint64_t>> weights;
  std::vector<std::vector<std::uint32_t>> ancestors;
  std::vector<StepState> states;
};

constexpr std::uint32_t kSteps = 7;  // enough for recorded steps to be started again

Trace run(FilterBackend& backend, const FilterBackendConfig& config, std::int64_t particles, bool fused,
          const GridMap& map = small_room(), std::uint32_t steps = kSteps) {
  backend.set_map(map);
  BeamTable beams;
  BeamCounts counts;
  backend.upload(uniform_start(map, particles, 7));
  Trace t;
  for (std::uint32_t step = 0; step < steps; ++step) {
    ScanConfig scan_config;
    scan_config.max_beams = step == 1 ? 110 : 40 + 10 * (step % 3);
    Scan scan = fan(120 - step);
    scan.range_max_m = step < 5 ? 4.0 : 3.0;
    select_beams(scan, scan_config, config.sensor, map.resolution_m, beams, counts);
    if (step % 3 == 2) spread_origins(beams);
    if (step == 0 || step == 5) backend.set_range_max(beams.range_max_m);
    const RandomKey key{99, step};
    const float turn_rad = 0.05f - 0.01f * static_cast<float>(step);
    backend.predict({turn_rad, 0.1f, -0.02f, 0.02f, 0.05f, 0.02f}, key);
    backend.set_scan(beams);
    if (step == 0 && casts_rays(config.sensor.model)) t.expected_m = backend.ray_trace();
    backend.weight(fused);
    backend.normalise_scan();
    backend.estimate();
    backend.resample(key);
    t.states.push_back(backend.finish());
    t.sets.push_back(backend.download());
    t.weights.push_back(backend.weights());
    t.ancestors.push_back(backend.ancestors());
  }
  return t;
}

void expect_same(const Trace& a, const Trace& b) {
  EXPECT_TRUE(same_bits(a.expected_m, b.expected_m));
  ASSERT_EQ(a.sets.size(), b.sets.size());
  for (std::size_t k = 0; k < a.sets.size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k));
    test::expect_same_bits(a.sets[k], b.sets[k]);
    EXPECT_TRUE(same_bits(a.weights[k], b.weights[k]));
    EXPECT_TRUE(same_bits(a.ancestors[k], b.ancestors[k]));
    EXPECT_EQ(a.states[k].total, b.states[k].total);
    EXPECT_EQ(a.states[k].resample, b.states[k].resample);
    EXPECT_EQ(a.states[k].n_eff, b.states[k].n_eff);
    EXPECT_TRUE(same_bits(a.states[k].all, b.states[k].all));
    EXPECT_TRUE(same_bits(a.states[k].cluster, b.states[k].cluster));
  }
}

struct Case {
  const char* name;
  SensorModel model;
  ResampleScheme scheme = ResampleScheme::systematic;
  RayCaster caster = RayCaster::skip;
  FieldLookup lookup = FieldLookup::nearest;
  bool segments = false;
};

class Backends : public testing::TestWithParam<Case> {
 protected:
  FilterBackendConfig config(std::int64_t particles, int threads) const {
    FilterBackendConfig c;
    c.particles = particles;
    c.threads = threads;
    c.sensor.model = GetParam().model;
    c.sensor.caster = GetParam().caster;
    c.sensor.lookup = GetParam().lookup;
    c.sensor.do_beamskip = GetParam().model == SensorModel::likelihood_field_prob;
    // The particles of this room are never together; so many agree that a part of the beams is skipped.
    c.sensor.beam_skip_spread = 1000.0, c.sensor.beam_skip_distance = 0.3;
    c.sensor.z_hit = 0.75, c.sensor.z_short = 0.1, c.sensor.z_max = 0.05, c.sensor.z_rand = 0.1;
    const bool by_number = GetParam().caster == RayCaster::fixed_step;
    c.sensor.tempering = by_number ? 0.1 : 0.0;  // else an exponent that changes from step to step
    c.sensor.effective_beams = 9.0;
    c.resample.scheme = GetParam().scheme;
    return c;
  }
  Trace cpu(std::int64_t particles, int threads, bool fused = true) const {
    const auto backend = make_cpu_filter_backend(config(particles, threads));
    return run(*backend, config(particles, threads), particles, fused, map());
  }
  GridMap map() const { return GetParam().segments ? room_of_segments() : small_room(); }
};

// Around block edges (1024, 256), one particle, and enough to use every thread.
const std::int64_t kCounts[] = {1, 31, 257, 1025, 9001};

TEST_P(Backends, KernelBodiesOnTheHostAndAnyNumberOfThreadsAgree) {
  for (const std::int64_t n : kCounts) {
    SCOPED_TRACE(n);
    const Trace one = cpu(n, 1);
    const auto kernels = cuda_on_host::make_filter_backend_on_host(config(n, 1));
    expect_same(one, run(*kernels, config(n, 1), n, true, map()));
    expect_same(one, cpu(n, 2));
    expect_same(one, cpu(n, 4));
  }
}

TEST_P(Backends, InstructionSetDoesNotMatter) {
  const Trace best = cpu(1025, 2);
  for (const cpu::Simd level : {cpu::Simd::avx2, cpu::Simd::baseline}) {
    const test::SimdLimit limit(level);
    expect_same(best, cpu(1025, 2));
  }
}

TEST_P(Backends, FusedEqualsUnfused) {
  expect_same(cpu(1025, 2, true), cpu(1025, 2, false));
}

TEST_P(Backends, GpuEqualsCpu) {
  std::unique_ptr<FilterBackend> gpu;
  std::string why;
  PARLOC_NEEDS_GPU(gpu = make_filter_backend(BackendChoice::cuda, config(9001, 1), why));
  expect_same(cpu(9001, 2), run(*gpu, config(9001, 1), 9001, true, map()));
}

// So many that the kernels spread them in another way.
constexpr std::int64_t kMany = 33001;

Trace of_many(FilterBackend& backend, const FilterBackendConfig& config) {
  return run(backend, config, kMany, true, small_room(), 2);
}
FilterBackendConfig config_of_many() {
  return {.particles = kMany, .threads = 2, .sensor = default_sensor(SensorModel::likelihood_field)};
}

TEST(ManyParticles, KernelBodiesOnTheHostAgree) {
  const FilterBackendConfig c = config_of_many();
  expect_same(of_many(*make_cpu_filter_backend(c), c),
              of_many(*cuda_on_host::make_filter_backend_on_host(c), c));
}

TEST(ManyParticles, GpuEqualsCpu) {
  const FilterBackendConfig c = config_of_many();
  std::unique_ptr<FilterBackend> gpu;
  std::string why;
  PARLOC_NEEDS_GPU(gpu = make_filter_backend(BackendChoice::cuda, c, why));
  expect_same(of_many(*make_cpu_filter_backend(c), c), of_many(*gpu, c));
}

std::vector<Case> all_cases() {
  using enum SensorModel;
  using enum ResampleScheme;
  using enum RayCaster;
  const FieldLookup bilinear = FieldLookup::bilinear;
  return {{"gaussian", gaussian, multinomial},
          {"paz2012", gaussian, multinomial_linear, fixed_step},
          {"beam_skip", beam, residual},
          {"beam_dda", beam, stratified, dda},
          {.name = "field", .model = likelihood_field, .lookup = bilinear},
          {"field_nearest", likelihood_field, stratified},
          {"s5", s5},
          {"class_conditional", class_conditional},
          {.name = "field_prob", .model = likelihood_field_prob, .lookup = bilinear},
          {"field_prob_nearest", likelihood_field_prob, stratified},
          {.name = "segments", .model = gaussian, .segments = true},
          {.name = "segments_one_by_one", .model = beam, .caster = dda, .segments = true},
          {.name = "segments_class_conditional", .model = class_conditional, .segments = true},
          {"segments_field_prob", likelihood_field_prob, systematic, skip, bilinear, true}};
}
INSTANTIATE_TEST_SUITE_P(All, Backends, testing::ValuesIn(all_cases()),
                         [](const auto& one) { return std::string(one.param.name); });

Trace cpu_run(SensorModel model, RayCaster caster, ResampleScheme scheme, std::int64_t particles,
              const GridMap& map = small_room()) {
  const FilterBackendConfig c{
      .particles = particles, .sensor = {.model = model, .caster = caster}, .resample = {.scheme = scheme}};
  return run(*make_cpu_filter_backend(c), c, particles, true, map);
}

TEST(References, TheSkippingCasterGivesTheRangesOfDda) {
  const auto with = [](RayCaster caster) {
    return cpu_run(SensorModel::gaussian, caster, ResampleScheme::systematic, 3000);
  };
  expect_same(with(RayCaster::skip), with(RayCaster::dda));
}

TEST(References, SegmentsAreFoundByCellAsByTryingAll) {
  for (const SensorModel model : {SensorModel::gaussian, SensorModel::beam}) {
    const auto with = [&](RayCaster caster) {
      return cpu_run(model, caster, ResampleScheme::systematic, 3000, room_of_segments());
    };
    expect_same(with(RayCaster::skip), with(RayCaster::dda));
  }
}

// Most particles have no wall in reach, which the skipping caster sees at once; some have.
TEST(References, AnEmptyPlaceIsWeighedAsByDda) {
  std::vector<std::string> rows(160, std::string(160, '.'));
  for (std::size_t j = 0; j < 160; ++j) rows[j].replace(0, 3, "###");
  const GridMap map = grid_from_text(rows, 0.05);
  Scan scan = fan(120);
  scan.range_max_m = 1.5;
  const auto weights = [&](RayCaster caster, SensorModel model, bool spread) {
    FilterBackendConfig c{.particles = 2000, .sensor = default_sensor(model)};
    c.sensor.caster = caster;
    BeamTable beams;
    BeamCounts counts;
    select_beams(scan, ScanConfig{}, c.sensor, map.resolution_m, beams, counts);
    if (spread) spread_origins(beams);
    const auto backend = make_cpu_filter_backend(c);
    backend->set_map(map);
    backend->upload(uniform_start(map, c.particles, 3));
    backend->set_scan(beams);
    backend->weight(true);
    backend->normalise_scan();
    backend->finish();
    return backend->weights();
  };
  for (const SensorModel model :
       {SensorModel::gaussian, SensorModel::s5, SensorModel::beam, SensorModel::class_conditional})
    for (const bool spread : {false, true})
      EXPECT_EQ(weights(RayCaster::skip, model, spread), weights(RayCaster::dda, model, spread));
}

TEST(References, MultinomialBisectionEqualsTheLinearSearch) {
  const auto with = [](ResampleScheme scheme) {
    return cpu_run(SensorModel::likelihood_field, RayCaster::skip, scheme, 1000);
  };
  expect_same(with(ResampleScheme::multinomial), with(ResampleScheme::multinomial_linear));
}

}  // namespace
}  // namespace parloc
