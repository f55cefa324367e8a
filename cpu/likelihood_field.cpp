#include "cpu/likelihood_field.h"

namespace parloc::cpu {

void likelihood_table(const std::vector<std::uint32_t>& squared_cells, std::int32_t width,
                      std::int32_t height, const DistanceLikelihood& likelihood, Workers& workers,
                      std::vector<std::uint32_t>& table) {
  table.resize(table_size(width, height));
  const std::uint32_t* squared = squared_cells.data();
  std::uint32_t* out = table.data();
  parallel_for(table.size(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t at = begin; at < end; ++at)
      out[at] = table_entry(likelihood, squared, width, height, at);
  });
}

}  // namespace parloc::cpu
