// The table of the likelihood field over a whole map, with OpenMP.
#pragma once

#include <cstdint>
#include <vector>

#include "common/model/likelihood_field.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

/// Fills `table`, table_size() entries, from squared distances [cells^2], width x height.
void likelihood_table(const std::vector<std::uint32_t>& squared_cells, std::int32_t width,
                      std::int32_t height, const DistanceLikelihood& likelihood, Workers& workers,
                      std::vector<std::uint32_t>& table);

}  // namespace parloc::cpu
