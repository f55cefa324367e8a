#include "cuda/scan.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct ReadValue {
  const std::uint64_t* from;
  PARLOC_HD std::uint64_t operator()(std::size_t i) const { return from[i]; }
};

struct AddBefore {
  std::uint64_t* sums;
  const std::uint64_t* before;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < count; i += me.stride()) sums[i] += before[i / kSumBlock];
  }
};

}  // namespace

void inclusive_scan(std::uint64_t* sums, std::size_t count, Queue& queue) {
  if (count == 0) return;
  queue.scratch.before.reserve(sum_blocks(count));
  std::uint64_t* const before = queue.scratch.before.data();
  scan_in_blocks(ReadValue{sums}, count, sums, before, queue);
  if (count > kSumBlock) launch(AddBefore{sums, before, count}, blocks_for(count), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
