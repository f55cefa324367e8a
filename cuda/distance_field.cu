#include "common/map/distance_field.h"

#include "cuda/stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct Columns {
  const std::uint8_t* is_source;
  std::uint32_t* field;
  std::int32_t width, height;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < static_cast<std::size_t>(width); i += me.stride())
      column_distances(is_source + i, field + i, 1, height, width);
  }
};

struct Rows {
  std::uint32_t* field;  // of the batch's first row
  std::int32_t width;
  std::size_t rows;
  RowParabola* scratch;  // [rows][width]
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t j = me.first(); j < rows; j += me.stride()) {
      const std::size_t first = j * static_cast<std::size_t>(width);
      row_squared_distances(field + first, width, scratch + first);
    }
  }
};

constexpr std::size_t kScratchBytes = std::size_t{64} << 20;

std::size_t rows_per_batch(std::size_t width, std::size_t height) {
  const std::size_t fitting = std::max<std::size_t>(kScratchBytes / (width * sizeof(RowParabola)), kThreads);
  return std::min(fitting, height);
}

}  // namespace

// One thread per column, then one per row; rows go in batches, so that beside the result it takes at most
// 64 MiB, or 12 bytes per cell of 256 rows.
void FilterStages::squared_distance_field(const std::uint8_t* is_source, std::int32_t width,
                                          std::int32_t height, std::uint32_t* field, Queue& queue) {
  const std::size_t columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  launch(Columns{is_source, field, width, height}, blocks_for(columns), queue);
  const std::size_t batch = rows_per_batch(columns, rows);
  DeviceBuffer<RowParabola> scratch;
  scratch.reserve(batch * columns);
  for (std::size_t j = 0; j < rows; j += batch) {
    const std::size_t here = std::min(batch, rows - j);
    launch(Rows{field + j * columns, width, here, scratch.data()}, blocks_for(here), queue);
  }
  queue.wait();  // before the scratch goes
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
