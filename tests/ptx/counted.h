// What was counted since ptx::forget_counts(), as JSON: for the model of a GPU's time
// (tools/studies/gpu_model.py).
#pragma once

#include <nlohmann/json.hpp>

#include "tests/ptx/runtime/names.h"
#include "tests/ptx/runtime/report.h"

namespace parloc::test {

inline nlohmann::json counted() {
  nlohmann::json kernels;
  for (const auto& [kernel, counts] : ptx::counts_of_all()) {
    nlohmann::json& k = kernels[ptx::readable_name(kernel->name)];
    k = {{"symbol", kernel->name},
         {"launches", counts.launches},
         {"blocks", counts.blocks},
         {"threads", counts.threads},
         {"longest_warp", counts.longest_warp},
         {"block_chains", counts.block_chains},
         {"issued_in", counts.issued_in}};
    for (std::size_t kind = 0; kind < ptx::kKinds; ++kind)
      if (counts.issued[kind] > 0) k["issued"][ptx::kKindNames[kind]] = counts.issued[kind];
  }
  const ptx::HostCounts& host = ptx::host_counts();
  return {{"kernels", kernels},
          {"copies", host.copies},
          {"allocations", host.allocations},
          {"waits", host.waits},
          {"graph_launches", host.graph_launches}};
}

}  // namespace parloc::test
