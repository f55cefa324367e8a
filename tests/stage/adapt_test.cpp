// The stage that chooses the number of particles: the parallel forms of both backends against the loop that
// draws one candidate after the other.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "common/filter/bind.h"
#include "cpu/stages.h"
#include "cuda/stages.h"

namespace parloc {
namespace {

/// Weighted particles, and everything that the stage needs besides.
struct Scene {
  std::vector<float> x, y, theta;
  std::vector<std::uint64_t> cumulative;
  std::vector<std::uint32_t> free = {5, 17, 18, 900};
  std::uint32_t count, to_count = 0;
  StepState state;
  KldRule rule;
  StepInput input;

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
    input.key = {seed * 977ull, seed % 13};
  }
  AdaptArgs args(BinTable bins) {
    return {.from = {x.data(), y.data(), theta.data(), nullptr, &count, rule.most},
            .to = {nullptr, nullptr, nullptr, nullptr, &to_count, rule.most},
            .weights = {nullptr, cumulative.data()},
            .rule = rule,
            .free = {free.data(), 4, 100, 0.05f},
            .bins = bins,
            .state = &state,
            .input = &input};
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
  const AdaptArgs args = scene.args(table.view());
  Found found{};
  found.loop = one_by_one(with_input(args));

  cpu::Queue workers;
  workers.threads = threads;
  cpu::FilterStages::adapt(args, workers);
  found.cpu = scene.to_count;
  EXPECT_EQ(scene.state.next_count, scene.to_count);
  EXPECT_TRUE(table.empty());

  scene.to_count = scene.state.next_count = 0;
  cuda_on_host::Queue queue(0);
  queue.reserve(scene.rule.most);
  cuda_on_host::FilterStages::adapt(args, queue);
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

}  // namespace
}  // namespace parloc
