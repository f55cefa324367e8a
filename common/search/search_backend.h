// The exhaustive part of the global search, on a backend.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/search/search_map.h"
#include "common/search/search_scan.h"

namespace parloc {

/// Champions: by top block and heading bin (kTurnBins) the best pose of the lattice, as pose_key.
class SearchBackend {
 public:
  virtual ~SearchBackend() = default;
  virtual std::string name() const = 0;
  /// `champions` gets those whose score is at least task.threshold(the best of all), in no order. `task` says
  /// nothing of memory: neither grid nor offsets.
  virtual void search(const SearchTask& task, const SearchScan& scan,
                      std::vector<std::uint64_t>& champions) = 0;
};

/// Defined in cpu/global_search.cpp and cuda/global_search.cu. The map outlives the backend.
std::unique_ptr<SearchBackend> make_cpu_search(const SearchMap& map, int threads);
/// Throws Error{backend} if there is no such device.
std::unique_ptr<SearchBackend> make_cuda_search(const SearchMap& map, int device);

}  // namespace parloc
