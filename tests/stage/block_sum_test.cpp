// The sum of the kernels (cuda/block_sum.h), run on the host, against that of the loops: as many particles as
// take each of its ways, from one block that four share to three levels.
#include "cuda/block_sum.h"

#include <gtest/gtest.h>

#include "cpu/block_sum.h"
#include "tests/stage/same_bits.h"

namespace parloc {
namespace {

constexpr int kSums = 3;

/// Values of all sizes and both signs, so that another order gives other bits.
struct Term {
  SumVector<kSums> operator()(std::size_t i) const {
    const double x = static_cast<double>(i * 2654435761u % 1000003) - 500000.0;
    return {{x, 1.0 / (x + 0.25), x * x * 1e-7}};
  }
};

struct Finish {
  double* to;
  void operator()(unsigned t, const double* sums) const {
    if (t < kSums) to[t] = sums[t];
  }
};

std::vector<double> by_kernel(std::uint32_t count, std::size_t capacity) {
  cuda_on_host::Queue queue(0);
  queue.reserve(capacity);
  std::vector<double> sums(kSums);
  cuda_on_host::block_sum<kSums>(Particles{.live = &count, .capacity = capacity}, Term{}, Finish{sums.data()},
                                 queue);
  return sums;
}

std::vector<double> by_loop(std::size_t count) {
  cpu::Workers workers;
  const SumVector<kSums> sums = cpu::block_sum<kSums>(count, workers, Term{});
  return {sums.v, sums.v + kSums};
}

constexpr std::uint32_t kFew = 1024 * cuda_on_host::SumShape::kFewBlocks;

TEST(BlockSum, KernelEqualsLoop) {
  for (const std::uint32_t count : {1u, 255u, 1024u, 1025u, 4096u, 4097u, 20000u, kFew, kFew + 1, 40000u,
                                    1024u * 1024u, 1024u * 1024u + 1, 3333333u}) {
    SCOPED_TRACE(count);
    EXPECT_TRUE(test::same_bits(by_loop(count), by_kernel(count, count)));
  }
}

TEST(BlockSum, RoomForMoreParticlesThanThereAreChangesNoBit) {
  for (const std::uint32_t count : {1u, 700u, 5000u})
    for (const std::size_t capacity : {std::size_t{5001}, std::size_t{kFew}, std::size_t{kFew} + 1}) {
      SCOPED_TRACE(std::to_string(count) + " of " + std::to_string(capacity));
      EXPECT_TRUE(test::same_bits(by_loop(count), by_kernel(count, capacity)));
    }
}

}  // namespace
}  // namespace parloc
