// The exact squared Euclidean distance field of a whole map, as kernels.
#pragma once

#include <cstdint>

#include "common/map/distance_field.h"
#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// field[j * width + i] as cpu/distance_field.h says; is_source and field are device memory. One thread per
/// column, then one per row; rows go in batches, so that beside the result it takes at most 64 MiB, or 12
/// bytes per cell of 256 rows. Synchronises: it is made once per map.
void squared_distance_field(const std::uint8_t* is_source, std::int32_t width, std::int32_t height,
                            std::uint32_t* field, Stream stream);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
