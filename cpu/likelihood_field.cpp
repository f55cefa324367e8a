#include "cpu/stages.h"

namespace parloc::cpu {

void FilterStages::likelihood_table(const std::uint32_t* squared, std::int32_t width, std::int32_t height,
                                    const DistanceLikelihood& likelihood, std::uint32_t* out,
                                    Queue& workers) {
  const std::size_t stride = static_cast<std::size_t>(width) + 2, rows = static_cast<std::size_t>(height) + 2;
  const auto loop = [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t j = end; j-- > begin;)  // from above, so that a cell's value is worked out once
      for (std::size_t at = j * stride; at < (j + 1) * stride; ++at)
        out[at] = j + 1 == end ? table_entry(likelihood, squared, width, height, at)
                               : packed_entry(table_value(likelihood, squared, width, height, at),
                                              static_cast<std::int32_t>(out[at + stride]));
  };
  parallel_blocks(rows, table_size(width, height) < kSmallLoop ? 1 : workers.threads, 1, loop);
  out[rows * stride] = table_entry(likelihood, squared, width, height, rows * stride);
}

}  // namespace parloc::cpu
