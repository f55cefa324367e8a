#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct FillTable {
  const std::uint32_t* squared_cells;
  std::int32_t width, height;
  DistanceLikelihood likelihood;
  std::uint32_t* table;
  std::size_t size;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t at = me.first(); at < size; at += me.stride())
      table[at] = table_entry(likelihood, squared_cells, width, height, at);
  }
};

}  // namespace

void FilterStages::likelihood_table(const std::uint32_t* squared_cells, std::int32_t width,
                                    std::int32_t height, const DistanceLikelihood& likelihood,
                                    std::uint32_t* table, Queue& queue) {
  const std::size_t size = table_size(width, height);
  launch(FillTable{squared_cells, width, height, likelihood, table, size}, blocks_for(size), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
