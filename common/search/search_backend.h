// The exhaustive part of the global search, on a backend.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/search/search_map.h"
#include "common/search/search_scan.h"
#include "common/search/search_work.h"

namespace parloc {

/// The parts of a search that LatticeSearch puts together; each may be done in pieces. Rows are rows of
/// blocks of the task's: row r of heading n is item n * rows + r.
class SearchBackend {
 public:
  virtual ~SearchBackend() = default;
  virtual std::string name() const = 0;

  /// A new search; any other is forgotten. `task` says nothing of memory: neither grid nor offsets. `scan`
  /// has the offsets of the task's headings, and is left alone until the search is over.
  virtual void begin(const SearchTask& task, const SearchScan& scan) = 0;
  /// Forgets the champions of rows of the map.
  virtual void clear(SearchItems rows) = 0;
  /// Looks for the best block of the heading in the middle of each round of the dive.
  virtual void sweep_dive(SearchItems rows) = 0;
  /// Searches those blocks at the headings of their rounds.
  virtual void dive(SearchItems headings) = 0;
  /// Finds the blocks whose bound reaches the threshold, which no other part may raise meanwhile.
  virtual void sweep(SearchItems rows) = 0;
  /// How many blocks were found since they were last forgotten: kMostFound at most, or those of one heading.
  virtual std::size_t found() = 0;
  /// Searches found blocks, in any order.
  virtual void search_found(SearchItems found) = 0;
  virtual void forget_found() = 0;
  /// Adds the champions of rows of the map whose score is at least task.threshold(the best of all), in any
  /// order.
  virtual void gather(SearchItems rows, std::vector<std::uint64_t>& champions) = 0;

  /// Returns when all that was asked for is done.
  virtual void wait() = 0;

  /// All of it at once: champions are, by block and heading bin (kTurnBins), the best pose of the lattice, as
  /// pose_key.
  void search(const SearchTask& task, const SearchScan& scan, std::vector<std::uint64_t>& champions);
};

/// Strips of kSweepLanes blocks that are swept with one threshold, or those of one heading.
constexpr std::size_t kRoundStrips = std::size_t{1} << 16;
constexpr std::size_t kMostFound = kRoundStrips * kSweepLanes;

/// Defined in cpu/global_search.cpp and cuda/global_search.cu. The map outlives the backend.
std::unique_ptr<SearchBackend> make_cpu_search(const SearchMap& map, int threads);
/// Throws Error{backend} if there is no such device.
std::unique_ptr<SearchBackend> make_cuda_search(const SearchMap& map, int device);

}  // namespace parloc
