// Every flow and Kalman filter: the kernel bodies run on the host, the OpenMP loops at several thread counts
// and instruction sets, and a GPU where there is one, all from the same input, must agree to the bit.
#include <gtest/gtest.h>

#include <ostream>

#include "common/filter/start.h"
#include "common/flow/flow_backend.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/room_scan.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<FlowBackend> make_flow_backend_on_host(const FlowBackendConfig& config);
}
namespace {

GridMap room() {
  return test::room_of_blocks(test::rows_with_blocks_and_wall());
}

/// Every fifth beam that returns is cut short.
Scan scan_from(const GridMap& map, const Pose& pose, std::size_t beams) {
  Scan s = test::scan_with_gaps(map, pose, beams, 4.0);
  for (std::size_t i = 2; i < beams; i += 5)
    if (s.ranges_m[i] <= 4.0f) s.ranges_m[i] *= 0.8f;
  return s;
}

/// Everything that a step leaves, as numbers in a row.
std::vector<double> numbers_of(const FlowState& s) {
  std::vector<double> n;
  const auto add = [&n](const double* from, std::size_t count) { n.insert(n.end(), from, from + count); };
  for (const PoseGaussian* g : {&s.prior, &s.posterior}) add(g->mean.v, 3), add(g->covariance.m, 9);
  add(s.centre.v, 3);
  const Moments& m = s.cloud;
  for (const double v : {m.x, m.y, m.theta, m.resultant, m.xx, m.xy, m.xt, m.yy, m.yt, m.tt}) n.push_back(v);
  add(s.scan.slope.v, 3);
  for (const double v : {s.scan.psi_m, s.scan.range_slope_sq, s.scan.beams, s.nis, s.stiffness, s.r_scale,
                         static_cast<double>(s.skip)})
    n.push_back(v);
  return n;
}

struct Trace {
  std::vector<std::vector<double>> states;
  std::vector<ParticleSet> sets;
  std::size_t used = 0, resampled = 0;
};

Trace run(FlowBackend& backend, const FlowBackendConfig& config) {
  const GridMap map = room();
  backend.set_map(map);
  const Pose start = compose(map.T_map_grid, {2.0, 1.5, 0.4});
  PoseGaussian gaussian;
  gaussian.mean[0] = 2.0, gaussian.mean[1] = 1.5, gaussian.mean[2] = 0.4;
  gaussian.covariance = diagonal3(0.01, 0.01, 0.0025);
  backend.start(gaussian_start(map, start, 0.1, 0.1, 0.05, config.particles, 7), gaussian);
  Trace t;
  Pose truth = compose(start, {0.05, -0.04, 0.03});
  BeamTable beams;
  BeamCounts counts;
  for (std::uint32_t step = 0; step < 8; ++step) {  // enough for recorded steps to be started again
    ScanConfig scan_config;
    scan_config.max_beams = step == 1 ? 300 : 100 + 45 * static_cast<int>(step % 3);
    const float turn_rad = 0.05f - 0.01f * static_cast<float>(step);
    const MotionStep motion{turn_rad, 0.05f, -0.02f, 0.02f, 0.02f, 0.02f};
    truth = compose(compose(truth, {0, 0, turn_rad}), {0.05, 0, -0.02});
    select_beams(scan_from(map, truth, 320 - step), scan_config, SensorConfig{}, map.resolution_m, beams,
                 counts);
    const FlowState& state = backend.step(motion, {99, step}, step == 4 ? nullptr : &beams);
    t.states.push_back(numbers_of(state));
    t.used += state.skip == FlowSkip::none ? 1 : 0;
    t.resampled += backend.weights_state().resample;
    t.sets.push_back(backend.download());
  }
  return t;
}

void expect_same(const Trace& a, const Trace& b) {
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k));
    EXPECT_TRUE(test::same_bits(a.states[k], b.states[k]));
    test::expect_same_bits(a.sets[k], b.sets[k]);
  }
}

struct Case {
  const char* name;
  FlowMethod method;
  FlowPrior prior = FlowPrior::recentred;
  FieldInterpolation interpolation = FieldInterpolation::bilinear;
  FlowSchedule schedule = FlowSchedule::uniform;
  double z_score = 0.0;
  FlowIntegrator integrator = FlowIntegrator::automatic;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class FlowBackends : public testing::TestWithParam<Case> {
 protected:
  FlowBackendConfig config(std::int64_t particles, int threads) const {
    const Case& p = GetParam();
    FlowBackendConfig c;
    c.particles = is_kalman(p.method) ? 0 : particles;
    c.threads = threads;
    c.method = p.method;
    c.flow.prior = p.prior;
    c.flow.interpolation = p.interpolation;
    c.flow.schedule = p.schedule;
    c.flow.integrator = p.integrator;
    c.flow.z_score = p.z_score;
    c.flow.steps = 5;
    c.resample.scheme = p.prior == FlowPrior::sample ? ResampleScheme::residual : ResampleScheme::systematic;
    return c;
  }
  Trace cpu(std::int64_t particles, int threads) const {
    return run(*make_cpu_flow_backend(config(particles, threads)), config(particles, threads));
  }
  /// Particles that flow one by one take long.
  std::vector<std::int64_t> counts() const {
    const bool one_by_one = GetParam().method == FlowMethod::ledh || GetParam().method == FlowMethod::pfpf;
    if (one_by_one) return {1, 9, 300};
    return {1, 31, 257, 1025, 9001};
  }
};

TEST_P(FlowBackends, KernelBodiesOnTheHostAndAnyNumberOfThreadsAgree) {
  for (const std::int64_t n : counts()) {
    SCOPED_TRACE(n);
    const Trace one = cpu(n, 1);
    const auto kernels = cuda_on_host::make_flow_backend_on_host(config(n, 1));
    expect_same(one, run(*kernels, config(n, 1)));
    expect_same(one, cpu(n, 2));
    expect_same(one, cpu(n, 4));
  }
}

TEST_P(FlowBackends, InstructionSetDoesNotMatter) {
  const Trace best = cpu(counts().back(), 2);
  for (const cpu::Simd level : {cpu::Simd::avx2, cpu::Simd::baseline}) {
    const test::SimdLimit limit(level);
    expect_same(best, cpu(counts().back(), 2));
  }
}

// Bits that agree say nothing if nothing happened.
TEST_P(FlowBackends, TheScansAreUsed) {
  const Trace t = cpu(300, 1);
  EXPECT_EQ(t.used, 7u);  // of eight steps, one has no scan
  EXPECT_EQ(t.resampled > 0, GetParam().method == FlowMethod::pfpf);
}

TEST_P(FlowBackends, GpuEqualsCpu) {
  std::unique_ptr<FlowBackend> gpu;
  std::string why;
  PARLOC_NEEDS_GPU(gpu = make_flow_backend(BackendChoice::cuda, config(300, 1), why));
  expect_same(cpu(300, 2), run(*gpu, config(300, 1)));
}

std::vector<Case> all_cases() {
  using enum FieldInterpolation;
  using enum FlowSchedule;
  using Method = FlowMethod;
  using Prior = FlowPrior;
  const FlowIntegrator euler = FlowIntegrator::euler;
  return {{"ekf", Method::ekf},
          {.name = "ekf_z_score", .method = Method::ekf, .z_score = 3.0},
          {"ekf_beams", Method::ekf_beams},
          {.name = "ekf_beams_cubic", .method = Method::ekf_beams, .interpolation = cubic},
          {"edh", Method::edh},
          {"edh_published", Method::edh, Prior::ekf, cubic},
          {"naedh", Method::naedh},
          {"naedh_contract", Method::naedh, Prior::ekf, bilinear, contract},
          {"naedh_sample", Method::naedh, Prior::sample, bilinear, exponential, 3.0},
          {"ledh", Method::ledh},
          {"ledh_euler", Method::ledh, Prior::recentred, cubic, exponential, 0.0, euler},
          {"gromov", Method::gromov},
          {"gromov_ekf", Method::gromov, Prior::ekf},
          {"pfpf", Method::pfpf},
          {"pfpf_euler", Method::pfpf, Prior::sample, bilinear, contract, 0.0, euler}};
}
INSTANTIATE_TEST_SUITE_P(All, FlowBackends, testing::ValuesIn(all_cases()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace parloc
