#include "common/search/lattice_search.h"

#include <algorithm>
#include <limits>

namespace parloc {

void LatticeSearch::begin(SearchBackend& backend, const SearchTask& task, const SearchScan& scan,
                          std::vector<std::uint64_t>& champions) {
  backend_ = &backend;
  champions_ = &champions;
  champions.clear();
  task_ = task;
  round_ends_ = 0;
  backend.begin(task, scan);
  enter(Stage::clear);
}

std::size_t LatticeSearch::strips_of_row() const {
  return static_cast<std::size_t>((task_.block_end_i - task_.block_i + kSweepLanes - 1) / kSweepLanes);
}

std::int64_t LatticeSearch::slots_work() const {
  return std::int64_t{task_.block_end_i - task_.block_i} * kTurnBins / search_work::kSlots;
}

std::int64_t LatticeSearch::sweep_work() const {
  const bool narrow = task_.block_end_i - task_.block_i <= kBlockCells;
  const std::int64_t strip = narrow ? search_work::kNarrowBeam : search_work::kStripBeam;
  return static_cast<std::int64_t>(strips_of_row()) * strip * (task_.beams + search_work::kOtherBeams);
}

std::int64_t LatticeSearch::block_work() const {
  return search_work::kBlockBeam * (task_.beams + search_work::kOtherBeams);
}

std::int64_t LatticeSearch::advance(std::int64_t work) {
  std::int64_t spent = 0;
  do {
    spent += step(work - spent);
  } while (stage_ != Stage::done && spent < work);
  backend_->wait();
  return spent;
}

/// Goes on from `at_`, at most to `end`: as many items, each of so much work, as there is work left for, but
/// one at least.
template <class Work>
std::int64_t LatticeSearch::some_of(std::size_t end, std::int64_t each, std::int64_t work,
                                    const Work& work_off) {
  const std::int64_t most = std::max<std::int64_t>(1, work / std::max<std::int64_t>(1, each));
  const std::size_t count = std::min(end - at_, static_cast<std::size_t>(most));
  if (count > 0) work_off(SearchItems{at_, count});
  at_ += count;
  return static_cast<std::int64_t>(count) * each;
}

void LatticeSearch::begin_round() {
  const std::size_t strips = std::max<std::size_t>(1, rows() * strips_of_row());
  const std::size_t first = round_ends_;
  if (first == headings()) return enter(Stage::gather);
  round_ends_ = std::min(headings(), first + std::max<std::size_t>(1, kRoundStrips / strips));
  backend_->forget_found();
  enter(Stage::sweep, first * rows());
}

std::int64_t LatticeSearch::step(std::int64_t work) {
  std::int64_t spent = 0;
  switch (stage_) {
    case Stage::clear:
      spent = some_of(rows(), slots_work(), work, [&](SearchItems items) { backend_->clear(items); });
      if (at_ == rows()) enter(Stage::sweep_dive);
      break;
    case Stage::sweep_dive: {
      const std::size_t all = (headings() + kDiveStep - 1) / kDiveStep * rows();
      spent = some_of(all, sweep_work(), work, [&](SearchItems items) { backend_->sweep_dive(items); });
      if (at_ == all) enter(Stage::dive);
      break;
    }
    case Stage::dive:
      spent = some_of(headings(), block_work(), work, [&](SearchItems items) { backend_->dive(items); });
      if (at_ == headings()) begin_round();
      break;
    case Stage::sweep:
      spent = some_of(round_ends_ * rows(), sweep_work(), work,
                      [&](SearchItems items) { backend_->sweep(items); });
      if (at_ == round_ends_ * rows()) found_ = backend_->found(), enter(Stage::search_found);
      break;
    case Stage::search_found:
      spent = some_of(found_, block_work(), work, [&](SearchItems items) { backend_->search_found(items); });
      if (at_ == found_) begin_round();
      break;
    case Stage::gather:
      spent = some_of(rows(), slots_work(), work,
                      [&](SearchItems items) { backend_->gather(items, *champions_); });
      if (at_ == rows()) enter(Stage::done);
      break;
    case Stage::done:
      break;
  }
  return spent;
}

void SearchBackend::search(const SearchTask& task, const SearchScan& scan,
                           std::vector<std::uint64_t>& champions) {
  LatticeSearch whole;
  whole.begin(*this, task, scan, champions);
  while (!whole.done()) (void)whole.advance(std::numeric_limits<std::int64_t>::max());
}

}  // namespace parloc
