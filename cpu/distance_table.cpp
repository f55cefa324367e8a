#include "cpu/flow_stages.h"

namespace parloc::cpu {

void distance_table(const std::vector<std::uint32_t>& squared_cells, std::int32_t width, std::int32_t height,
                    Workers& workers, std::vector<DistancePair>& table) {
  table.resize(distance_table_size(width, height));
  const std::uint32_t* squared = squared_cells.data();
  DistancePair* out = table.data();
  parallel_for(table.size(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t at = begin; at < end; ++at) out[at] = table_pair(squared, width, height, at);
  });
}

}  // namespace parloc::cpu
