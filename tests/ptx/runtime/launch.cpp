#include "tests/ptx/runtime/launch.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <numeric>
#include <random>
#include <utility>

#include "tests/ptx/runtime/block.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

constexpr unsigned kLooks = 64;  // rounds in which a block looks for what others write, before others run
constexpr unsigned kMostTurns = 10000;  // of all blocks that look, before they are said to wait for ever

std::vector<std::uint32_t> order_of_blocks(std::uint64_t count, std::mt19937& random) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  if (settings().seed != 0) std::shuffle(order.begin(), order.end(), random);
  return order;
}

/// Until it is finished (true), or may wait for another block.
bool run_on(Block& block, std::mt19937& random) {
  for (unsigned looks = 0; looks < kLooks;) {
    const Block::Progress progress = block.run_round(random);
    if (progress == Block::Progress::finished) return true;
    if (progress == Block::Progress::looked) ++looks;
  }
  return false;
}

}  // namespace

void run_launch(const Launch& launch) {
  std::mt19937 random(settings().seed * 7919 + launch.number);
  RaceDetector::instance().begin();
  KernelCounts& counts = counts_of(*launch.kernel);
  ++counts.launches;
  counts.threads += launch.blocks.all() * launch.threads.all();

  std::deque<std::unique_ptr<Block>> waiting;
  for (const std::uint32_t number : order_of_blocks(launch.blocks.all(), random)) {
    auto block = std::make_unique<Block>(launch, number);
    if (!run_on(*block, random)) waiting.push_back(std::move(block));
  }
  std::size_t turns = 0;
  while (!waiting.empty()) {
    auto block = std::move(waiting.front());
    waiting.pop_front();
    if (run_on(*block, random)) {
      turns = 0;
      continue;
    }
    if (++turns > kMostTurns * (waiting.size() + 1))
      fault(block->unfinished(), "blocks wait for each other for ever");
    waiting.push_back(std::move(block));
  }
}

}  // namespace ptx
