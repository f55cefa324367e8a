#include "common/map/distance_field.h"

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "common/error.h"
#include "common/map/map_limits.h"
#include "cpu/stages.h"

namespace parloc::cpu {
namespace {

// Columns that pass 1 takes together: whole cache lines, and enough strips for many threads. On a 10,000 x
// 7,000 map any width from 16 to 5000 takes the same time within 10 %.
constexpr std::int32_t kStripColumns = 64;

void check(std::int32_t width, std::int32_t height, int threads) {
  if (width < 1 || height < 1 || width > kMaxMapSide || height > kMaxMapSide || threads < 1) {
    throw Error(ErrorKind::internal, "distance field of " + std::to_string(width) + " x " +
                                         std::to_string(height) + " cells on " + std::to_string(threads) +
                                         " threads: expected sides from 1 to " + std::to_string(kMaxMapSide) +
                                         " and at least 1 thread");
  }
}

}  // namespace

// Memory besides what is given: 12 bytes per column and thread.
void FilterStages::squared_distance_field(const std::uint8_t* is_source, std::int32_t width,
                                          std::int32_t height, std::uint32_t* field, Queue& workers) {
  const int threads = workers.threads;
  check(width, height, threads);
  const std::int64_t stride = width;
  const std::int32_t strips = (width + kStripColumns - 1) / kStripColumns;

#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (std::int32_t s = 0; s < strips; ++s) {
    const std::int32_t first = s * kStripColumns;
    const std::int32_t columns = std::min(kStripColumns, width - first);
    column_distances(is_source + first, field + first, columns, height, stride);
  }

  std::vector<RowParabola> scratch(static_cast<std::size_t>(width) * static_cast<std::size_t>(threads));
#pragma omp parallel for num_threads(threads) schedule(dynamic, 16)
  for (std::int32_t j = 0; j < height; ++j) {
    row_squared_distances(field + j * stride, width,
                          scratch.data() + static_cast<std::size_t>(omp_get_thread_num()) * stride);
  }
}

}  // namespace parloc::cpu
