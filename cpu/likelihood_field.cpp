#include "cpu/likelihood_field.h"

namespace parloc::cpu {

void likelihood_table(const std::vector<std::uint32_t>& squared_cells, std::int32_t width,
                      std::int32_t height, const DistanceLikelihood& likelihood, Workers& workers,
                      std::vector<float>& table) {
  table.resize((static_cast<std::size_t>(width) + 2) * (static_cast<std::size_t>(height) + 2));
  const std::uint32_t* squared = squared_cells.data();
  float* out = table.data();
  parallel_for(table.size(), workers.threads, [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
    for (std::size_t at = begin; at < end; ++at)
      out[at] = table_value(likelihood, squared, width, height, at);
  });
}

}  // namespace parloc::cpu
