// The stages as kernels; contract in common/filter/stages.h. All are asynchronous on the queue and can be
// recorded.
#pragma once

#include "common/filter/kld.h"
#include "common/filter/stages.h"
#include "cuda/queue.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

struct FilterStages {
#include "common/filter/stage_list.inc"
};

/// Empties a table that has at most so many bins.
void clear_used_bins(const BinTable& bins, std::size_t most, Queue& queue);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
