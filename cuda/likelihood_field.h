// The table of the likelihood field over a whole map, as a kernel.
#pragma once

#include <cstdint>

#include "common/model/likelihood_field.h"
#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Fills `table`, table_size() entries, from squared distances [cells^2], width x height; both
/// in device memory.
void likelihood_table(const std::uint32_t* squared_cells, std::int32_t width, std::int32_t height,
                      const DistanceLikelihood& likelihood, std::uint32_t* table, Stream stream);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
