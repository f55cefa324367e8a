#include "tests/ptx/runtime/launch.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <numeric>
#include <random>

#include "tests/ptx/runtime/block.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

constexpr unsigned kMostLooks =
    10000;  // of all waiting blocks in turn, before they are said to wait for ever

std::vector<std::uint32_t> order_of_blocks(std::uint64_t count, std::mt19937& random) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  if (settings().seed != 0) std::shuffle(order.begin(), order.end(), random);
  return order;
}

/// Until it is finished (true), or waits for another block.
bool run_on(Block& block, std::mt19937& random) {
  for (;;) {
    switch (block.run_round(random)) {
      case Block::Progress::finished:
        return true;
      case Block::Progress::waiting:
        return false;
      case Block::Progress::advanced:
        break;
    }
  }
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
  std::size_t looks = 0;
  while (!waiting.empty()) {
    auto block = std::move(waiting.front());
    waiting.pop_front();
    if (run_on(*block, random)) {
      looks = 0;
      continue;
    }
    if (++looks > kMostLooks * (waiting.size() + 1))
      fault(block->unfinished(), "blocks wait for each other for ever");
    waiting.push_back(std::move(block));
  }
}

}  // namespace ptx
