// Filters that step together (common/filter/filter_group.h) have the bits of each alone: of all sizes and
// kinds, some of which leave early or fail.
#include "common/filter/filter_group.h"

#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <functional>
#include <thread>

#include "common/filter/filter_backend.h"
#include "common/filter/start.h"
#include "cuda/space.h"
#include "tests/stage/room_of_blocks.h"
#include "tests/stage/same_bits.h"
#include "tests/unit/without_gpu.h"

namespace parloc {
namespace cuda_on_host {
std::unique_ptr<FilterBackend> make_filter_backend_on_host(const FilterBackendConfig& config);
std::shared_ptr<FilterGroup> make_filter_group_on_host();
}  // namespace cuda_on_host
namespace {

using Make = std::function<std::unique_ptr<FilterBackend>(const FilterBackendConfig&)>;
using Group = std::shared_ptr<FilterGroup>;

const GridMap& room() {
  static const GridMap map = test::room_of_blocks(test::rows_with_blocks_and_wall());
  return map;
}

struct Member {
  SensorModel model = SensorModel::likelihood_field;
  std::int64_t particles = 0;
  std::uint32_t steps = 6;
  std::int64_t fewest = 0;
  ResampleScheme scheme = ResampleScheme::systematic;
  bool fails = false;  // after its steps

  FilterBackendConfig config(const Group& group) const {
    return {.particles = particles,
            .threads = 1,
            .sensor = default_sensor(model),
            .resample = {.scheme = scheme},
            .min_particles = fewest,
            .group = group};
  }
};

const std::vector<Member> kMembers = {
    {.particles = 1},
    {.particles = 300},
    {.particles = 1500, .steps = 2},
    {.particles = 2600},
    {.particles = 700, .fails = true},
    {.model = SensorModel::gaussian, .particles = 257},
    {.model = SensorModel::gaussian, .particles = 33, .steps = 4},
    {.model = SensorModel::class_conditional, .particles = 90},
    {.particles = 900, .fewest = 50},
    {.particles = 120, .scheme = ResampleScheme::residual},
};

struct Trace {
  std::vector<StepState> states;
  ParticleSet last;
};

/// `together`: where it waits for others before each step is done.
Trace run(FilterBackend& backend, const Member& member, std::barrier<>* together = nullptr) {
  const SensorConfig sensor = default_sensor(member.model);
  backend.set_map(room());
  backend.upload(uniform_start(room(), member.particles, 7));
  Trace trace;
  BeamTable beams;
  BeamCounts counts;
  for (std::uint32_t step = 0; step < member.steps; ++step) {
    Scan scan{.angle_min_rad = -2.0, .angle_step_rad = 0.1, .range_max_m = 4.0};
    for (std::size_t i = 0; i < 20 + 6 * (step % 4); ++i)  // at the second and the third there is no room
      scan.ranges_m.push_back(0.5f + 0.013f * static_cast<float>((i * 29 + step) % 200));
    select_beams(scan, ScanConfig{}, sensor, room().resolution_m, beams, counts);
    if (step == 0) backend.set_range_max(beams.range_max_m);
    const RandomKey key{static_cast<std::uint64_t>(member.particles), step};
    backend.predict({0.05f, 0.1f, -0.02f, 0.02f, 0.05f, 0.02f}, key);
    backend.set_scan(beams);
    backend.weight(true);
    backend.normalise_scan();
    backend.estimate();
    backend.adapt(key, false);
    backend.resample(key);
    if (together != nullptr) together->arrive_and_wait();
    trace.states.push_back(backend.finish());
  }
  trace.last = backend.download();
  if (member.fails) backend.upload(uniform_start(room(), member.particles + 1, 7));
  return trace;
}

/// Its trace, or none if it has failed.
Trace run_one(const Make& make, const Member& member, const Group& group) {
  try {
    const auto backend = make(member.config(group));
    return run(*backend, member);
  } catch (const Error& error) {  // the others go on, without memory too (tests/ptx/out_of_memory)
    EXPECT_TRUE(member.fails) << error.what();
    return {};
  }
}

void expect_same(const Trace& a, const Trace& b) {
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    EXPECT_EQ(a.states[k].total, b.states[k].total);
    EXPECT_EQ(a.states[k].next_count, b.states[k].next_count);
    EXPECT_TRUE(test::same_bits(a.states[k].all, b.states[k].all));
    EXPECT_TRUE(test::same_bits(a.states[k].cluster, b.states[k].cluster));
  }
  test::expect_same_bits(a.last, b.last);
}

void expect_bits_of_each_alone(const Make& make, const Group& group) {
  std::vector<Trace> traces(kMembers.size());
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < kMembers.size(); ++k)
    threads.emplace_back([&, k] { traces[k] = run_one(make, kMembers[k], group); });
  for (std::thread& thread : threads) thread.join();
  std::uint64_t steps = 0;
  for (std::size_t k = 0; k < kMembers.size(); ++k) {
    SCOPED_TRACE("member " + std::to_string(k));
    steps += kMembers[k].steps;
    expect_same(run_one(make_cpu_filter_backend, kMembers[k], nullptr), traces[k]);
  }
  EXPECT_EQ(group->counts().steps, steps);
  EXPECT_LE(group->counts().batches, steps);
}

TEST(FilterGroup, KernelBodiesOnTheHostHaveTheBitsOfEachAlone) {
  expect_bits_of_each_alone(cuda_on_host::make_filter_backend_on_host,
                            cuda_on_host::make_filter_group_on_host());
}

TEST(FilterGroup, GpuHasTheBitsOfEachAlone) {
  Group group;
  PARLOC_NEEDS_GPU(group = make_filter_group({.backend = BackendChoice::cuda}));
  const Make make = [](const FilterBackendConfig& config) {
    std::string why;
    return make_filter_backend(BackendChoice::cuda, config, why);
  };
  expect_bits_of_each_alone(make, group);
}

TEST(FilterGroup, GpuDoesTogetherWhatComesTogether) {
  Group group;
  PARLOC_NEEDS_GPU(group = make_filter_group({.backend = BackendChoice::cuda}));
  constexpr std::size_t kSizes[] = {50, 257, 700, 1025, 90};
  std::barrier<> together(std::size(kSizes));
  std::vector<Trace> traces(std::size(kSizes));
  std::vector<std::thread> threads;
  std::string why;
  const auto member = [&](std::size_t k) {
    return Member{.particles = static_cast<std::int64_t>(kSizes[k]), .steps = 8};
  };
  std::vector<std::unique_ptr<FilterBackend>> backends;
  for (std::size_t k = 0; k < traces.size(); ++k)
    backends.push_back(make_filter_backend(BackendChoice::cuda, member(k).config(group), why));
  for (std::size_t k = 0; k < traces.size(); ++k)
    threads.emplace_back([&, k] { traces[k] = run(*backends[k], member(k), &together); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t k = 0; k < traces.size(); ++k)
    expect_same(run_one(make_cpu_filter_backend, member(k), nullptr), traces[k]);
  EXPECT_EQ(group->counts().steps, 40u);
  EXPECT_LT(group->counts().batches, 40u);  // of a step the first alone, then all others, if they are quick
}

TEST(FilterGroup, OnTheCpuThereIsNothingToShare) {
  EXPECT_EQ(make_filter_group({.backend = BackendChoice::cpu}), nullptr);
}

using namespace cuda_on_host;  // NOLINT

/// Adds so much to a number, block by block.
struct Add {
  std::uint64_t* to;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.thread == 0) *to += 1 + 1000 * me.blocks;
  }
};

// What is done in which order, on one thread.
TEST(StepGroup, ABatchIsTheWorkOfEach) {
  StepGroup group(0);
  const auto queue = std::make_unique<Queue>(0);
  std::uint64_t in = 5, there = 0, out = 0;
  const JoinedSequence one(group, *queue, [&] {
    copy_down(&there, &in, sizeof in, *queue);
    launch_step(Add{&there}, 3, *queue);
    launch_step(Add{&there}, 1, *queue);
    copy_up(&out, &there, sizeof out, *queue);
  });
  EXPECT_EQ(there, 0u);  // only noted
  one.run();
  EXPECT_EQ(out, 5u + 3 * 3001 + 1001);
  in = 7;
  one.run();
  EXPECT_EQ(out, 7u + 3 * 3001 + 1001);
  EXPECT_EQ(group.counts().steps, 2u);
}

/// Until so many wait.
struct WaitForOthers {
  const StepGroup* group;
  std::size_t others;
  std::atomic<bool>* begun;
  PARLOC_HD void operator()(const Thread&) const {
    *begun = true;
    while (group->waiting() < others) std::this_thread::yield();
  }
};

TEST(StepGroup, AllThatWaitAreOneBatchWhateverTheirNumberOfBlocks) {
  constexpr std::size_t kOthers = 6;
  StepGroup group(0);
  const Queue queue(0);
  std::atomic<bool> begun = false;
  std::vector<std::uint64_t> there(kOthers), out(kOthers);
  const JoinedSequence first(group, queue, [&] {
    launch_step(WaitForOthers{&group, kOthers, &begun}, 1, queue);
  });
  std::vector<std::unique_ptr<JoinedSequence>> others;
  for (std::size_t k = 0; k < kOthers; ++k)
    others.push_back(std::make_unique<JoinedSequence>(group, queue, [&] {
      launch_step(Add{&there[k]}, static_cast<unsigned>(k + 1), queue);
      copy_up(&out[k], &there[k], sizeof out[k], queue);
    }));
  std::vector<std::thread> threads;
  threads.emplace_back([&] { first.run(); });
  while (!begun) std::this_thread::yield();
  for (const auto& other : others) threads.emplace_back([&] { other->run(); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t k = 0; k < kOthers; ++k) EXPECT_EQ(out[k], (k + 1) * (1 + 1000 * (k + 1)));
  EXPECT_EQ(group.counts().steps, 1 + kOthers);
  EXPECT_EQ(group.counts().batches, 2u);
}

TEST(StepGroup, OneThatFindsNoMemoryChangesNothingForTheOthers) {
  StepGroup group(0);
  const Queue queue(0);
  std::uint64_t in = 5, there = 0;
  const JoinedSequence one(group, queue, [&] { copy_down(&there, &in, sizeof in, queue); });
  const auto too_much = [&] {
    const JoinedSequence other(group, queue, [&] { copy_up(&in, &there, std::size_t{1} << 62, queue); });
  };
  EXPECT_THROW(too_much(), std::bad_alloc);
  one.run();
  EXPECT_EQ(there, 5u);
}

TEST(StepGroup, AKernelThatIsNoPartOfAStepIsRefused) {
  StepGroup group(0);
  const Queue queue(0);
  std::uint64_t there = 0;
  const auto join = [&] { const JoinedSequence one(group, queue, [&] { launch(Add{&there}, 1, queue); }); };
  EXPECT_THROW(join(), Error);
  launch(Add{&there}, 1, queue);  // it notes no more
  EXPECT_EQ(there, 1001u);
}

}  // namespace
}  // namespace parloc
