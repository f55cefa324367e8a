// After an allocation that failed a backend works on: one allocation of the device after the other fails,
// once; the call throws one line, is made again when there is memory, or left out, and everything after it
// has the bits of a run in which nothing failed.
#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "common/error.h"
#include "common/filter/start.h"
#include "common/flow/flow_backend.h"
#include "common/slam/slam_backend.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/room_scan.h"
#include "tests/stage/same_bits.h"

namespace parloc {
namespace {

const GridMap& room() {
  static const GridMap map = test::room_of_blocks(test::rows_with_blocks_and_wall());
  return map;
}
/// The same, larger: there is more to the right.
const GridMap& larger_room() {
  static const GridMap map = [] {
    std::vector<std::string> rows = test::rows_with_blocks_and_wall();
    for (std::string& row : rows) row += std::string(90, '.') + "#";
    return test::room_of_blocks(rows);
  }();
  return map;
}

/// Where the robot is after so many steps, and what it sees there.
Pose truth_after(std::uint32_t step) {
  return compose(compose(room().T_map_grid, {2.0, 1.5, 0.4}), {0.06 * step, 0.0, 0.02 * step});
}
BeamTable scan_after(std::uint32_t step, int beams) {
  ScanConfig config;
  config.max_beams = beams;
  BeamTable table;
  BeamCounts counts;
  select_beams(test::scan_with_gaps(room(), truth_after(step), 120, 6.0), config, SensorConfig{},
               room().resolution_m, table, counts);
  return table;
}
constexpr MotionStep kMotion{0.0f, 0.06f, 0.02f, 0.02f, 0.02f, 0.02f};
constexpr std::int64_t kParticles = 8;
constexpr int kFewBeams = 12, kMoreBeams = 40;

/// Calls of one backend after the other, the first of which makes it; and what they leave, as numbers in a
/// row.
template <class Backend>
struct Drive {
  std::unique_ptr<Backend> backend;
  std::vector<double> left;

  template <class T>
  void note(const std::vector<T>& values) {
    left.insert(left.end(), values.begin(), values.end());
  }
  void note(const ParticleSet& p) {
    for (const auto* values : {&p.x, &p.y, &p.theta, &p.log_weight}) note(*values);
  }
};
template <class Backend>
using Calls = std::vector<std::function<void(Drive<Backend>&)>>;

void fail_allocation(std::uint64_t k) {
  ptx::settings().failing = k > 0 ? ptx::host_counts().allocations + k : 0;
}

template <class T>
std::vector<T> operator+(std::vector<T> a, const std::vector<T>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// With the k-th allocation failing, 0: none. Whether a call has failed; it is made again, or left out.
template <class Backend>
bool run(const Calls<Backend>& calls, std::uint64_t k, bool again, std::vector<double>& left) {
  Drive<Backend> drive;
  bool failed = false;
  fail_allocation(k);
  for (const auto& call : calls) {
    try {
      call(drive);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::backend);
      EXPECT_NE(std::string(error.what()).find(" MiB of "), std::string::npos) << error.what();
      EXPECT_FALSE(failed) << "only one fails";
      failed = true;
      if (again) call(drive);
    }
  }
  fail_allocation(0);
  left = std::move(drive.left);
  return failed;
}

/// Each allocation of these calls fails, one in a run.
template <class Backend>
void expect_to_go_on(const Calls<Backend>& calls, std::size_t least_failures) {
  std::vector<double> expected, left;
  const std::uint64_t before = ptx::host_counts().allocations;
  run(calls, 0, false, expected);
  const std::uint64_t allocations = ptx::host_counts().allocations - before;
  std::size_t failures = 0;
  for (std::uint64_t k = 1; k <= allocations; ++k) {
    SCOPED_TRACE("allocation " + std::to_string(k));
    failures += run(calls, k, true, left) ? 1 : 0;
    ASSERT_TRUE(test::same_bits(expected, left));
  }
  EXPECT_GE(failures, least_failures);
}
/// After a call that fails, whichever of its allocations it is, all is as if it had never been made.
template <class Backend>
void expect_as_before(const Calls<Backend>& first, const Calls<Backend>& failing,
                      const Calls<Backend>& rest) {
  std::vector<double> expected, left;
  run(first + rest, 0, false, expected);
  std::uint64_t k = 1;
  const auto fails = [](std::uint64_t at) {
    return Calls<Backend>{[at](Drive<Backend>&) { fail_allocation(at); }};
  };
  while (run(first + fails(k) + failing + fails(0) + rest, 0, false, left)) {
    SCOPED_TRACE("allocation " + std::to_string(k++));
    ASSERT_TRUE(test::same_bits(expected, left));
  }
  EXPECT_GT(k, 1u) << "it allocates nothing";
}

// ---- the particle filter
// ---------------------------------------------------------------------------------------------
using FilterDrive = Drive<FilterBackend>;

Calls<FilterBackend> filter_begins(SensorModel model) {
  return {[model](FilterDrive& d) {
            FilterBackendConfig config;
            config.particles = kParticles;
            config.sensor = default_sensor(model);
            std::string why;
            d.backend = make_filter_backend(BackendChoice::cuda, config, why);
          },
          [](FilterDrive& d) { d.backend->set_map(room()); },
          [](FilterDrive& d) { d.backend->set_range_max(6.0); },
          [](FilterDrive& d) {
            d.backend->upload(gaussian_start(room(), truth_after(0), 0.1, 0.1, 0.05, kParticles, 7));
          }};
}
Calls<FilterBackend> filter_steps(std::uint32_t first, std::uint32_t end, int beams) {
  Calls<FilterBackend> calls;
  for (std::uint32_t step = first; step < end; ++step) {
    calls.push_back([=](FilterDrive& d) { d.backend->set_scan(scan_after(step, beams)); });
    calls.push_back([=](FilterDrive& d) {
      d.backend->predict(kMotion, {5, step});
      d.backend->set_scan(scan_after(step, beams));
      d.backend->weight(true);
      d.backend->normalise_scan();
      d.backend->estimate();
      d.backend->resample({5, step});
      d.left.push_back(d.backend->finish().all.x);
      d.note(d.backend->download());
    });
  }
  return calls;
}
class FilterGoesOn : public testing::TestWithParam<SensorModel> {};
TEST_P(FilterGoesOn, OnAGpu) {
  const Calls<FilterBackend> change = {[](FilterDrive& d) { d.backend->set_map(larger_room()); }};
  const Calls<FilterBackend> begin = filter_begins(GetParam());
  const auto few = filter_steps(0, 3, kFewBeams), more = filter_steps(3, 5, kMoreBeams);
  expect_to_go_on(begin + few + more, 10);
  expect_as_before(begin + few, change, filter_steps(3, 5, kFewBeams));
  expect_as_before(begin + few, {[](FilterDrive& d) { d.backend->set_scan(scan_after(3, kMoreBeams)); }},
                   filter_steps(3, 5, kFewBeams));
}
INSTANTIATE_TEST_SUITE_P(All, FilterGoesOn,
                         testing::Values(SensorModel::beam, SensorModel::likelihood_field));

// ---- a filter on the distance field
// ----------------------------------------------------------------------------------
using FlowDrive = Drive<FlowBackend>;

Calls<FlowBackend> flow_begins() {
  return {[](FlowDrive& d) {
            FlowBackendConfig config;
            config.particles = kParticles;
            config.method = FlowMethod::pfpf;
            std::string why;
            d.backend = make_flow_backend(BackendChoice::cuda, config, why);
          },
          [](FlowDrive& d) { d.backend->set_map(room()); },
          [](FlowDrive& d) {
            PoseGaussian start;
            start.mean[0] = 2.0, start.mean[1] = 1.5, start.mean[2] = 0.4;
            start.covariance = diagonal3(0.01, 0.01, 0.0025);
            d.backend->start(gaussian_start(room(), truth_after(0), 0.1, 0.1, 0.05, kParticles, 7), start);
          }};
}
Calls<FlowBackend> flow_steps(std::uint32_t first, std::uint32_t end, int beams) {
  Calls<FlowBackend> calls;
  for (std::uint32_t step = first; step < end; ++step)
    calls.push_back([=](FlowDrive& d) {
      const BeamTable scan = scan_after(step, beams);
      d.left.push_back(d.backend->step(kMotion, {5, step}, &scan).posterior.mean[0]);
      d.note(d.backend->download());
    });
  return calls;
}
TEST(FlowFilterGoesOn, OnAGpu) {
  const auto few = flow_steps(0, 3, kFewBeams);
  expect_to_go_on(flow_begins() + few + flow_steps(3, 5, kMoreBeams), 10);
  expect_as_before(flow_begins() + few, {[](FlowDrive& d) { d.backend->set_map(larger_room()); }},
                   flow_steps(3, 5, kFewBeams));
  expect_as_before(flow_begins() + few, flow_steps(3, 4, kMoreBeams), flow_steps(3, 5, kFewBeams));
}

// ---- SLAM
// ------------------------------------------------------------------------------------------------------------
using SlamDrive = Drive<SlamBackend>;

Calls<SlamBackend> slam_begins() {
  return {[](SlamDrive& d) {
    SlamBackendConfig config;
    config.slam.particles = 3;
    config.slam.usable_range = 1.0;
    config.slam.proposal = SlamProposal::motion;  // matching allocates nothing, and takes its time
    config.slam.beta_weight = 0.5;                // so that it resamples
    std::string why;
    d.backend = make_slam_backend(BackendChoice::cuda, config, why);
  }};
}
/// Steps of `stride_m`: the tables do not reach so far for long.
Calls<SlamBackend> slam_steps(std::uint32_t first, std::uint32_t end, float stride_m) {
  Calls<SlamBackend> calls;
  for (std::uint32_t step = first; step < end; ++step)
    calls.push_back([=](SlamDrive& d) {
      const MotionStep motion{0.0f, stride_m, 0.0f, 0.02f, 0.05f, 0.02f};
      const SlamStep& done = d.backend->step(motion, {5, step}, scan_after(step, kFewBeams));
      d.note(done.x), d.note(done.y), d.note(done.theta), d.note(done.likelihood), d.note(done.ancestor);
      d.left.push_back(static_cast<double>(done.tiles));
      const SlamCells map = d.backend->map_of(1);
      d.left.push_back(static_cast<double>(std::accumulate(map.cell.begin(), map.cell.end(), CellWord{0})));
    });
  return calls;
}
TEST(SlamGoesOn, OnAGpu) {
  expect_to_go_on(slam_begins() + slam_steps(0, 2, 0.1f) + slam_steps(2, 3, 20.0f) + slam_steps(3, 5, 0.1f),
                  20);
  expect_as_before(slam_begins() + slam_steps(0, 2, 0.1f), slam_steps(2, 3, 20.0f), slam_steps(2, 4, 0.1f));
}

}  // namespace
}  // namespace parloc
