#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct FillTable {
  const std::uint32_t* squared_cells;
  std::int32_t width, height;
  DistancePair* table;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t size = distance_table_size(width, height);
    for (std::size_t at = me.first(); at < size; at += me.stride())
      table[at] = table_pair(squared_cells, width, height, at);
  }
};

}  // namespace

void FlowStages::distance_table(const std::uint32_t* squared_cells, std::int32_t width, std::int32_t height,
                                DistancePair* table, Queue& queue) {
  launch(FillTable{squared_cells, width, height, table}, blocks_for(distance_table_size(width, height)),
         queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
