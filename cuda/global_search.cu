#include <algorithm>

#include "common/filter/filter_backend.h"
#include "common/search/search_backend.h"
#include "cuda/queue.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

/// Rows of blocks of a task, counted through block by block.
struct Rows {
  SearchItems items;
  std::int32_t first_i, first_j;
  std::size_t width, height;  // of the task

  PARLOC_HD std::size_t count() const { return items.count * width; }
  PARLOC_HD std::int32_t i(std::size_t n) const { return first_i + static_cast<std::int32_t>(n % width); }
  PARLOC_HD std::int32_t j(std::size_t n) const {
    return first_j + static_cast<std::int32_t>((items.first + n / width) % height);
  }
  /// Which of the headings, or rounds of the dive.
  PARLOC_HD std::size_t turn(std::size_t n) const { return (items.first + n / width) / height; }
};

/// Bound of a free block, 0 if it is below `least`.
PARLOC_HD std::uint32_t swept(const SearchTask& t, std::int32_t k, std::int32_t i, std::int32_t j,
                              std::uint32_t least) {
  if (t.grid.free_blocks[std::int64_t{j} * t.grid.blocks_x() + i] == 0) return 0;
  const std::uint32_t bound = bound_of_block(t, k, i, j, least);
  return bound < least ? 0 : bound;
}

/// Scores pose `n` of a block and records it.
PARLOC_HD void search_pose(const SearchTask& t, const SearchFinds& finds, std::int32_t k,
                           std::int32_t block_i, std::int32_t block_j, std::size_t n) {
  const std::int32_t i = block_i * kBlockCells + static_cast<std::int32_t>(n % kBlockCells);
  const std::int32_t j = block_j * kBlockCells + static_cast<std::int32_t>(n / kBlockCells);
  if (!pose_counts(t, i, j)) return;
  const std::uint32_t least = t.threshold(atomic_read(finds.best));
  const std::uint32_t score = score_of_pose(t, k, i, j, least);
  if (score >= least) record_pose(t, finds, k, i, j, score);
}

/// The heading in the middle of a round of the dive.
PARLOC_HD std::int32_t middle_of(const SearchTask& t, std::size_t round) {
  const std::int32_t first = static_cast<std::int32_t>(round) * kDiveStep;
  return t.heading(first + kDiveStep / 2 < t.heading_count ? first + kDiveStep / 2 : first);
}

/// Nothing was found yet.
struct Begin {
  std::uint32_t* best;
  std::uint64_t* count;
  std::uint64_t* tops;
  std::size_t rounds;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *best = 0, *count = 0;
    for (std::size_t r = me.first(); r < rounds; r += me.stride()) tops[r] = 0;
  }
};

/// The champions of some rows of the map, counted through.
struct Slots {
  std::size_t rows, first, width, stride;
  PARLOC_HD std::size_t count() const { return rows * width; }
  PARLOC_HD std::size_t at(std::size_t n) const { return first + n / width * stride + n % width; }
};

struct Clear {
  Slots slots;
  std::uint64_t* champion;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t n = me.first(); n < slots.count(); n += me.stride()) champion[slots.at(n)] = 0;
  }
};

struct DiveSweep {
  SearchTask t;
  Rows rows;
  std::uint64_t* tops;  // by round: the block with the highest bound
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t n = me.first(); n < rows.count(); n += me.stride()) {
      const std::size_t round = rows.turn(n);
      const std::int32_t i = rows.i(n), j = rows.j(n);
      const std::uint32_t bound = swept(t, middle_of(t, round), i, j, t.least);
      const std::int32_t block = j * t.grid.blocks_x() + i;
      if (bound > 0) atomic_raise(tops + round, block_key(bound, static_cast<std::uint32_t>(block)));
    }
  }
};

struct Dive {
  SearchTask t;
  SearchFinds finds;
  SearchItems headings;
  const std::uint64_t* tops;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::int32_t width = t.grid.blocks_x();
    for (std::size_t n = me.first(); n < headings.count * kBlockPoses; n += me.stride()) {
      const std::size_t heading = headings.first + n / kBlockPoses;
      const std::uint64_t top = tops[heading / kDiveStep];
      if (top == 0) continue;
      const std::int32_t block = static_cast<std::int32_t>(block_of_key(top));
      search_pose(t, finds, t.heading(static_cast<std::int32_t>(heading)), block % width, block / width,
                  n % kBlockPoses);
    }
  }
};

struct Node {
  std::int32_t k, i, j;
};

/// Which blocks of some headings have to be searched.
struct Sweep {
  SearchTask t;
  Rows rows;
  const std::uint32_t* best;
  Node* nodes;
  std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint32_t least = t.threshold(*best);
    for (std::size_t n = me.first(); n < rows.count(); n += me.stride()) {
      const std::int32_t k = t.heading(static_cast<std::int32_t>(rows.turn(n)));
      if (swept(t, k, rows.i(n), rows.j(n), least) > 0)
        nodes[atomic_add(count, std::uint64_t{1})] = {k, rows.i(n), rows.j(n)};
    }
  }
};

/// Every pose of some of those blocks.
struct Descend {
  SearchTask t;
  SearchFinds finds;
  SearchItems found;
  const Node* nodes;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t n = me.first(); n < found.count * kBlockPoses; n += me.stride()) {
      const Node& node = nodes[found.first + n / kBlockPoses];
      search_pose(t, finds, node.k, node.i, node.j, n % kBlockPoses);
    }
  }
};

struct Reset {
  std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *count = 0;
  }
};

/// Champions that count, side by side.
struct Gather {
  SearchTask t;
  SearchFinds finds;
  Slots slots;
  std::uint64_t* out;
  std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint32_t least = t.threshold(*finds.best);
    for (std::size_t n = me.first(); n < slots.count(); n += me.stride()) {
      const std::uint64_t key = finds.champion[slots.at(n)];
      if (key != 0 && (key >> 40) >= least) out[atomic_add(count, std::uint64_t{1})] = key;
    }
  }
};

class CudaSearch final : public SearchBackend {
 public:
  CudaSearch(const SearchMap& map, int device) : queue_(device) {
    const std::size_t champions = map.free_blocks.size() * kTurnBins;
    cells_.from_host(map.cells.bytes, queue_);
    windows_.from_host(map.windows.bytes, queue_);
    free_cells_.from_host(map.free_cells, queue_);
    free_blocks_.from_host(map.free_blocks, queue_);
    grid_ = map.shape;
    grid_.cells.first = cells_.data() + map.cells.first;
    grid_.windows.first = windows_.data() + map.windows.first;
    grid_.free_cells = free_cells_.data();
    grid_.free_blocks = free_blocks_.data();
    best_.reserve(1);
    champion_.reserve(champions);
    gathered_.reserve(champions);
    count_.reserve(1);
    host_count_.reserve(1);
    nodes_.reserve(std::max(kMostFound, map.free_blocks.size()));
    queue_.wait();
  }

  std::string name() const override { return queue_.name(); }

  void begin(const SearchTask& asked, const SearchScan& scan) override {
    queue_.use();
    task_ = asked;
    task_.grid = grid_;
    upload_offsets(scan);
    task_.offsets = offsets_.data();
    const std::size_t rounds = static_cast<std::size_t>((task_.heading_count + kDiveStep - 1) / kDiveStep);
    tops_.reserve(rounds);
    launch(Begin{best_.data(), count_.data(), tops_.data(), rounds}, blocks_for(rounds), queue_);
    queue_.wait();  // the scan is the caller's again
  }

  void clear(SearchItems rows) override {
    queue_.use();
    const Slots slots = slots_of(rows);
    launch(Clear{slots, champion_.data()}, blocks_for(slots.count()), queue_);
  }

  void sweep_dive(SearchItems items) override {
    queue_.use();
    const Rows rows = rows_of(items);
    launch(DiveSweep{task_, rows, tops_.data()}, blocks_for(rows.count()), queue_);
  }

  void dive(SearchItems headings) override {
    queue_.use();
    launch(Dive{task_, finds(), headings, tops_.data()}, blocks_for(headings.count * kBlockPoses), queue_);
  }

  void sweep(SearchItems items) override {
    queue_.use();
    const Rows rows = rows_of(items);
    launch(Sweep{task_, rows, best_.data(), nodes_.data(), count_.data()}, blocks_for(rows.count()), queue_);
  }

  std::size_t found() override { return counted(); }

  void search_found(SearchItems found) override {
    queue_.use();
    launch(Descend{task_, finds(), found, nodes_.data()}, blocks_for(found.count * kBlockPoses), queue_);
  }

  void forget_found() override {
    queue_.use();
    launch(Reset{count_.data()}, 1, queue_);
  }

  void wait() override { queue_.wait(); }

  void gather(SearchItems rows, std::vector<std::uint64_t>& champions) override {
    queue_.use();
    const Slots slots = slots_of(rows);
    launch(Reset{count_.data()}, 1, queue_);
    launch(Gather{task_, finds(), slots, gathered_.data(), count_.data()}, blocks_for(slots.count()), queue_);
    const std::size_t before = champions.size(), found = counted();
    champions.resize(before + found);
    if (found > 0)
      copy_up(champions.data() + before, gathered_.data(), found * sizeof(std::uint64_t), queue_);
    queue_.wait();
  }

 private:
  SearchFinds finds() const { return {best_.data(), champion_.data()}; }

  Rows rows_of(SearchItems items) const {
    return {items, task_.block_i, task_.block_j, static_cast<std::size_t>(task_.block_end_i - task_.block_i),
            static_cast<std::size_t>(task_.block_end_j - task_.block_j)};
  }

  Slots slots_of(SearchItems rows) const {
    const auto across = static_cast<std::size_t>(task_.grid.blocks_x());
    const auto width = static_cast<std::size_t>(task_.block_end_i - task_.block_i);
    const std::size_t first = (static_cast<std::size_t>(task_.block_j) + rows.first) * across +
                              static_cast<std::size_t>(task_.block_i);
    return {rows.count, first * kTurnBins, width * kTurnBins, across * kTurnBins};
  }

  /// Those of the headings asked for, which may begin anew at the first.
  void upload_offsets(const SearchScan& scan) {
    offsets_.reserve(static_cast<std::size_t>(scan.headings) * static_cast<std::size_t>(scan.beams));
    const std::int32_t end = task_.first_heading + task_.heading_count;
    upload_headings(scan, task_.first_heading, std::min(end, task_.headings));
    upload_headings(scan, 0, std::max(0, end - task_.headings));
  }

  void upload_headings(const SearchScan& scan, std::int32_t first, std::int32_t end) {
    const auto beams = static_cast<std::size_t>(scan.beams);
    const std::size_t at = static_cast<std::size_t>(first) * beams;
    const std::size_t count = static_cast<std::size_t>(end - first) * beams;
    if (count > 0) copy_down(offsets_.data() + at, scan.offsets.data() + at, count * sizeof(Offset), queue_);
  }

  std::size_t counted() {
    copy_up(host_count_.data(), count_.data(), sizeof(std::uint64_t), queue_);
    queue_.wait();
    return static_cast<std::size_t>(*host_count_.data());
  }

  Queue queue_;
  SearchGrid grid_;
  SearchTask task_;
  DeviceBuffer<std::uint8_t> cells_, windows_, free_cells_, free_blocks_;
  DeviceBuffer<Offset> offsets_;
  DeviceBuffer<std::uint32_t> best_;
  DeviceBuffer<std::uint64_t> champion_, gathered_, tops_, count_;
  HostBuffer<std::uint64_t> host_count_;
  DeviceBuffer<Node> nodes_;
};

}  // namespace

#if !defined(__CUDACC__)
std::unique_ptr<SearchBackend> make_search_on_host(const SearchMap& map) {
  return std::make_unique<CudaSearch>(map, 0);
}
#endif
}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
std::unique_ptr<SearchBackend> make_cuda_search(const SearchMap& map, int device) {
  return std::make_unique<cuda::CudaSearch>(map, device);
}
#endif

}  // namespace parloc
