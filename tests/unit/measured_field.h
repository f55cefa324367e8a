// The distance field of a whole map by the CPU's stage.
#pragma once

#include "cpu/stages.h"

namespace parloc::test {

inline std::vector<std::uint32_t> squared_distance_field(const std::uint8_t* is_source, std::int32_t width,
                                                         std::int32_t height, int threads) {
  std::vector<std::uint32_t> field(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  cpu::Queue queue;
  queue.threads = threads;
  cpu::FilterStages::squared_distance_field(is_source, width, height, field.data(), queue);
  return field;
}

}  // namespace parloc::test
