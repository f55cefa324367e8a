// The exhaustive part of the global search, in slices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/search/lattice.h"
#include "common/search/search_backend.h"

namespace parloc {

/// The order of the work is fixed: a round of headings is swept with the threshold known when it began, then
/// all blocks that were found are searched, and what they hold sets the next round's threshold. So the work
/// of a search is the same however it is sliced, on every backend and thread count.
class LatticeSearch {
 public:
  /// The backend and the scan outlive the search; `champions` are emptied, and complete when it is done.
  void begin(SearchBackend& backend, const SearchTask& task, const SearchScan& scan,
             std::vector<std::uint64_t>& champions);
  /// Does about so much work [search_work.h], but something; returns how much it was.
  std::int64_t advance(std::int64_t work);
  bool done() const { return stage_ == Stage::done; }

 private:
  enum class Stage { clear, sweep_dive, dive, sweep, search_found, gather, done };
  std::size_t rows() const { return static_cast<std::size_t>(task_.block_end_j - task_.block_j); }
  std::size_t strips_of_row() const;
  std::size_t headings() const { return static_cast<std::size_t>(task_.heading_count); }
  std::int64_t slots_work() const;
  std::int64_t sweep_work() const;
  std::int64_t block_work() const;

  void enter(Stage stage, std::size_t first = 0) { stage_ = stage, at_ = first; }
  std::int64_t step(std::int64_t work);
  void begin_round();
  template <class Work>
  std::int64_t some_of(std::size_t end, std::int64_t each, std::int64_t work, const Work& work_off);

  SearchBackend* backend_ = nullptr;
  std::vector<std::uint64_t>* champions_ = nullptr;
  SearchTask task_;
  Stage stage_ = Stage::done;
  std::size_t at_ = 0;          // what is next in this stage
  std::size_t round_ends_ = 0;  // heading
  std::size_t found_ = 0;       // blocks of this round
};

}  // namespace parloc
