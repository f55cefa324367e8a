// Grid SLAM: the kernel bodies run on the host, the OpenMP loops at several thread counts and instruction
// sets, and a GPU where there is one, all from the same input, must agree to the bit: poses, weights,
// ancestors and maps.
#include <gtest/gtest.h>

#include <sstream>

#include "common/file/bytes.h"
#include "common/slam/checkpoint_values.h"
#include "common/slam/slam_backend.h"
#include "common/slam/sub_maps.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/room_scan.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/instruction_sets.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<SlamBackend> make_slam_backend_on_host(const SlamBackendConfig& config);
}
namespace {

constexpr double kRangeMax_m = 6.0;

struct Trace {
  std::vector<SlamStep> steps;
  std::vector<SlamCells> maps;  ///< Of the first and the last particle, at the end.
  std::size_t resampled = 0;
};

constexpr std::uint32_t kSteps = 12;

/// Into another backend, as a checkpoint does.
void hand_over(const SlamBackend& from, SlamBackend& to, const SlamConfig& config) {
  std::string bytes;
  ByteWriter w([&](const void* data, std::size_t n) { bytes.append(static_cast<const char*>(data), n); });
  put_backend(w, from);
  w.flush();
  std::istringstream in(bytes);
  ByteReader r(in, bytes.size(), "bytes");
  get_backend(r, to, config);
  EXPECT_EQ(r.left(), 0u);
}

/// Drives 3 m through the room. From step `change` on with the backend `next`, which takes over.
Trace run(SlamBackend& first, const SlamBackendConfig& config, std::uint32_t change = 0xffffffffu,
          SlamBackend* next = nullptr) {
  const GridMap map = test::room_of_blocks(test::rows_with_blocks_and_wall());
  Pose truth = compose(map.T_map_grid, {0.8, 1.5, 0.1});
  Trace t;
  BeamTable beams;
  BeamCounts counts;
  ScanConfig scan_config;
  for (std::uint32_t step = 0; step < kSteps; ++step) {
    if (step == change) hand_over(first, *next, config.slam);
    SlamBackend& backend = step < change ? first : *next;
    scan_config.max_beams = step == 3 ? 200 : 90 + 20 * static_cast<int>(step % 3);
    const float turn_rad = step % 4 == 2 ? 0.3f : -0.1f;
    const bool moves = step > 0;
    const MotionStep motion{moves ? turn_rad : 0.0f, moves ? 0.22f : 0.0f, 0.0f, 0.05f, 0.03f, 0.05f};
    if (moves) truth = compose(compose(truth, {0, 0, turn_rad}), {0.25, 0, 0});
    select_beams(test::scan_with_gaps(map, truth, 220 - step, kRangeMax_m), scan_config, SensorConfig{},
                 config.slam.resolution, beams, counts);
    t.steps.push_back(backend.step(motion, {99, step}, beams));
    t.resampled += t.steps.back().state.resample;
  }
  for (const std::int64_t k : {std::int64_t{0}, config.slam.particles - 1})
    t.maps.push_back((change < kSteps ? *next : first).map_of(static_cast<std::size_t>(k)));
  return t;
}

void expect_same(const Trace& a, const Trace& b) {
  ASSERT_EQ(a.steps.size(), b.steps.size());
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    SCOPED_TRACE("step " + std::to_string(k));
    const SlamStep &x = a.steps[k], &y = b.steps[k];
    EXPECT_TRUE(test::same_bits(x.x, y.x));
    EXPECT_TRUE(test::same_bits(x.y, y.y));
    EXPECT_TRUE(test::same_bits(x.theta, y.theta));
    EXPECT_TRUE(test::same_bits(x.likelihood, y.likelihood));
    EXPECT_TRUE(test::same_bits(x.ancestor, y.ancestor));
    EXPECT_EQ(x.state.n_eff, y.state.n_eff);
    EXPECT_EQ(x.tiles, y.tiles);
  }
  for (std::size_t k = 0; k < a.maps.size(); ++k) {
    SCOPED_TRACE("map " + std::to_string(k));
    EXPECT_EQ(a.maps[k].first_i, b.maps[k].first_i);
    EXPECT_EQ(a.maps[k].width, b.maps[k].width);
    EXPECT_TRUE(test::same_bits(a.maps[k].cell, b.maps[k].cell));
  }
}

/// 30 m long and 2 m wide.
GridMap corridor_with_posts() {
  std::vector<std::string> rows(40, std::string(600, '.'));
  rows.front() = rows.back() = std::string(600, '#');
  // Posts on both walls, without which a scan says nothing of the distance.
  for (std::size_t i = 0; i < 600; ++i)
    if (i % 16 < 3 || i % 23 < 2) rows[1][i] = rows[2][i] = rows[37][i] = rows[38][i] = '#';
  return grid_from_text(rows, 0.05);
}

/// Anything in the tile whose first cell this is.
bool has_visits(const SlamCells& map, std::int32_t i0, std::int32_t j0) {
  for (std::int32_t j = j0; j < j0 + kTileCells; ++j)
    for (std::int32_t i = i0; i < i0 + kTileCells; ++i)
      if (map.cell[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) +
                   static_cast<std::size_t>(i)] != 0)
        return true;
  return false;
}

struct Variant {
  const char* name;
  SlamProposal proposal;
  bool search = false;   ///< Wide, before the matcher climbs.
  double clear_m = 0.0;  ///< So far beams that saw nothing are drawn.
};

class SlamBackends : public testing::TestWithParam<Variant> {
 protected:
  SlamBackendConfig config(std::int64_t particles, int threads) const {
    SlamBackendConfig c;
    c.slam.particles = particles;
    c.slam.proposal = GetParam().proposal;
    c.slam.search_xy = GetParam().search ? 0.55 : 0.0;  // 3 x 3 blocks, the last of them cut
    c.slam.search_theta = GetParam().search ? 0.1 : 0.0;
    c.slam.usable_range = 4.0;  // some beams are cut
    c.slam.clear_range = GetParam().clear_m;
    c.slam.beta_weight = 0.5;  // so that it resamples
    c.threads = threads;
    return c;
  }
  /// A wide search takes its time.
  static std::int64_t few() { return GetParam().search ? 5 : 21; }
  Trace cpu(std::int64_t particles, int threads) const {
    return run(*make_cpu_slam_backend(config(particles, threads)), config(particles, threads));
  }
};

TEST_P(SlamBackends, KernelBodiesOnTheHostEqualTheOpenMpTwin) {
  for (const std::int64_t n : {1, 7, 40}) {
    SCOPED_TRACE(n);
    const auto kernels = cuda_on_host::make_slam_backend_on_host(config(n, 1));
    expect_same(cpu(n, 1), run(*kernels, config(n, 1)));
  }
}

TEST_P(SlamBackends, ThreadsDoNotMatter) {
  const Trace one = cpu(33, 1);
  expect_same(one, cpu(33, 2));
  expect_same(one, cpu(33, 5));
}

TEST_P(SlamBackends, InstructionSetDoesNotMatter) {
  const Trace best = cpu(12, 2);
  for (const cpu::Simd level : test::instruction_sets()) {
    const test::SimdLimit limit(level);
    expect_same(best, cpu(12, 2));
  }
}

// Bits that agree say nothing if nothing happened.
TEST_P(SlamBackends, ParticlesDifferAndAreResampled) {
  const Trace t = cpu(40, 1);
  EXPECT_GT(t.resampled, 0u);
  EXPECT_LT(t.resampled, kSteps);
  EXPECT_NE(t.steps.back().x[0], t.steps.back().x[39]);
  EXPECT_FALSE(test::same_bits(t.maps[0].cell, t.maps[1].cell));
}

// In a long corridor, of which a scan sees little: what particles inherited they share.
TEST_P(SlamBackends, ParticlesShareTiles) {
  SlamBackendConfig near = config(40, 1);
  near.slam.usable_range = 1.5;
  near.slam.search_xy = near.slam.search_theta = 0.0;  // it would hold on to the little that is known
  near.slam.resample_threshold = 1.0;                  // every step
  const GridMap corridor = corridor_with_posts();
  const auto backend = make_cpu_slam_backend(near);
  BeamTable beams;
  BeamCounts counts;
  std::size_t tiles_in_use = 0;
  for (std::uint32_t step = 0; step < 40; ++step) {
    select_beams(test::scan_with_gaps(corridor, {2.0 + 0.6 * step, 1.0, 0.0}, 90, kRangeMax_m), ScanConfig{},
                 SensorConfig{}, 0.05, beams, counts);
    const float trans_m = step > 0 ? 0.6f : 0.0f;
    tiles_in_use = backend->step({0.0f, trans_m, 0.0f, 0.01f, 0.02f, 0.01f}, {5, step}, beams).tiles - 1;
  }
  const SlamCells map = backend->map_of(0);
  std::size_t tiles = 0;
  for (std::int32_t j = 0; j < map.height; j += kTileCells)
    for (std::int32_t i = 0; i < map.width; i += kTileCells) tiles += has_visits(map, i, j) ? 1 : 0;
  EXPECT_GE(tiles, 30u);
  EXPECT_LT(tiles_in_use, 40 * tiles / 2);
}

/// There and back along the corridor with so little memory that what is far is handed over. With `late` it is
/// not given back in time: particles then have tiles of their own where some are handed over, which add up.
struct HandedOver {
  std::vector<std::size_t> places, tiles;
  SlamCells map;
  SlamStep last;
};
HandedOver there_and_back(SlamBackend& backend, const SlamConfig& slam, const GridMap& corridor, bool late) {
  SubMaps sub_maps(slam);
  HandedOver out;
  BeamTable beams;
  BeamCounts counts;
  for (std::uint32_t step = 0; step < 60; ++step) {
    const double x_m = 2.0 + 0.6 * (step < 30 ? step : 60 - step);
    select_beams(test::scan_with_gaps(corridor, {x_m, 1.0, 0.0}, 90, kRangeMax_m), ScanConfig{},
                 SensorConfig{}, slam.resolution, beams, counts);
    const float trans_m = step == 0 ? 0.0f : step <= 30 ? 0.6f : -0.6f;
    if (!late || step > 50) sub_maps.give_back(backend, 0.6);
    backend.move({0.0f, trans_m, 0.0f, 0.01f, 0.02f, 0.01f}, {5, step}, beams, sub_maps.most_tiles());
    sub_maps.make_room(backend);
    out.last = backend.write();
    out.tiles.push_back(out.last.tiles);
    out.places.push_back(sub_maps.places());
  }
  out.map = backend.map_of(1);
  sub_maps.add_to(out.map);
  return out;
}

TEST_P(SlamBackends, FarPlacesAreHandedOverAndGivenBackOnBoth) {
  SlamBackendConfig c = config(12, 2);
  c.slam.usable_range = 1.5;
  if (GetParam().search) c.slam.search_xy = 0.1, c.slam.search_theta = 0.03;  // a wide one takes its time
  c.slam.resolution = 0.025;
  c.slam.resample_threshold = 0.3;  // seldom: then particles share little
  c.slam.beta_weight = 0.05;
  c.slam.memory_mib = 5;
  const GridMap corridor = corridor_with_posts();
  for (const bool late : {false, true}) {
    SCOPED_TRACE(late);
    const HandedOver cpu = there_and_back(*make_cpu_slam_backend(c), c.slam, corridor, late);
    EXPECT_GT(*std::max_element(cpu.places.begin(), cpu.places.end()), 10u);
    EXPECT_FALSE(std::is_sorted(cpu.places.begin(), cpu.places.end()));  // some were given back
    for (const std::size_t tiles : cpu.tiles) EXPECT_LE(tiles * sizeof(Tile), std::size_t{5} << 20);
    const HandedOver kernels =
        there_and_back(*cuda_on_host::make_slam_backend_on_host(c), c.slam, corridor, late);
    EXPECT_EQ(cpu.places, kernels.places);
    EXPECT_EQ(cpu.tiles, kernels.tiles);
    EXPECT_TRUE(test::same_bits(cpu.last.x, kernels.last.x));
    EXPECT_TRUE(test::same_bits(cpu.last.likelihood, kernels.last.likelihood));
    EXPECT_TRUE(test::same_bits(cpu.map.cell, kernels.map.cell));
  }
}

TEST_P(SlamBackends, StartsAnew) {
  const auto backend = make_cpu_slam_backend(config(9, 1));
  const Trace first = run(*backend, config(9, 1));
  backend->start();
  expect_same(first, run(*backend, config(9, 1)));
}

// From a checkpoint of one backend the other goes on.
TEST_P(SlamBackends, TakeOverFromEachOther) {
  const std::int64_t particles = few();
  const SlamBackendConfig c = config(particles, 2);
  const Trace whole = cpu(particles, 2);
  for (const std::uint32_t change : {0u, 1u, 5u, 8u, kSteps - 1}) {
    SCOPED_TRACE(change);
    const auto one = make_cpu_slam_backend(c), other = make_cpu_slam_backend(c);
    const auto kernels = cuda_on_host::make_slam_backend_on_host(c);
    expect_same(whole, run(*one, c, change, other.get()));
    one->start();
    expect_same(whole, run(*one, c, change, kernels.get()));
    kernels->start();
    other->start();
    expect_same(whole, run(*kernels, c, change, other.get()));
  }
}

// Into a backend that has done something else before, whose tiles are then free.
TEST_P(SlamBackends, WhatIsTakenOverReplacesWhatWas) {
  const SlamBackendConfig c = config(few(), 2);
  const Trace whole = cpu(few(), 2);
  const auto one = make_cpu_slam_backend(c), other = make_cpu_slam_backend(c);
  const auto kernels = cuda_on_host::make_slam_backend_on_host(c);
  for (SlamBackend* used : {other.get(), kernels.get()}) {
    run(*used, c);
    one->start();
    expect_same(whole, run(*one, c, 6, used));
  }
}

TEST_P(SlamBackends, GpuEqualsCpu) {
  std::unique_ptr<SlamBackend> gpu;
  std::string why;
  PARLOC_NEEDS_GPU(gpu = make_slam_backend(BackendChoice::cuda, config(40, 1), why));
  const Trace whole = cpu(40, 2);
  expect_same(whole, run(*gpu, config(40, 1)));
  const auto host = make_cpu_slam_backend(config(40, 2));
  expect_same(whole, run(*host, config(40, 2), 5, gpu.get()));
  gpu->start();
  expect_same(whole, run(*gpu, config(40, 2), 7, host.get()));
}

INSTANTIATE_TEST_SUITE_P(All, SlamBackends,
                         testing::Values(Variant{"motion", SlamProposal::motion},
                                         Variant{"scan_match", SlamProposal::scan_match},
                                         Variant{"gaussian", SlamProposal::gaussian},
                                         Variant{"gaussian_clears", SlamProposal::gaussian, false, 3.0},
                                         Variant{"scan_match_search", SlamProposal::scan_match, true},
                                         Variant{"gaussian_search", SlamProposal::gaussian, true}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace parloc
