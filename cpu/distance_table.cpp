#include "cpu/flow_stages.h"

namespace parloc::cpu {

void FlowStages::distance_table(const std::uint32_t* squared, std::int32_t width, std::int32_t height,
                                DistancePair* out, Queue& workers) {
  parallel_for(distance_table_size(width, height), workers.threads,
               [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                 for (std::size_t at = begin; at < end; ++at)
                   out[at] = table_pair(squared, width, height, at);
               });
}

}  // namespace parloc::cpu
