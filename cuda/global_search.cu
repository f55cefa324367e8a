#include <algorithm>

#include "common/filter/filter_backend.h"
#include "common/search/search_backend.h"
#include "cuda/queue.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

/// Nodes of one launch at most; as many headings are swept at a time as fit whatever their bounds.
constexpr std::size_t kNodes = std::size_t{1} << 22;

/// The blocks of a task, counted through.
struct Blocks {
  std::int32_t first_i, first_j, width, height;
  PARLOC_HD std::size_t count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  PARLOC_HD std::int32_t i(std::size_t n) const {
    return first_i + static_cast<std::int32_t>(n % static_cast<std::size_t>(width));
  }
  PARLOC_HD std::int32_t j(std::size_t n) const {
    return first_j + static_cast<std::int32_t>(n / static_cast<std::size_t>(width));
  }
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

struct Clear {
  SearchFinds finds;
  std::size_t champions;
  std::uint64_t* tops;
  std::size_t rounds;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() == 0) *finds.best = 0;
    for (std::size_t c = me.first(); c < champions; c += me.stride()) finds.champion[c] = 0;
    for (std::size_t r = me.first(); r < rounds; r += me.stride()) tops[r] = 0;
  }
};

struct DiveSweep {
  SearchTask t;
  Blocks blocks;
  std::size_t rounds;
  std::uint64_t* tops;  // by round: the block with the highest bound
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t count = blocks.count();
    for (std::size_t n = me.first(); n < rounds * count; n += me.stride()) {
      const std::size_t round = n / count, b = n % count;
      const std::int32_t i = blocks.i(b), j = blocks.j(b);
      const std::uint32_t bound = swept(t, middle_of(t, round), i, j, t.least);
      const std::int32_t block = j * t.grid.blocks_x() + i;
      if (bound > 0) atomic_raise(tops + round, block_key(bound, static_cast<std::uint32_t>(block)));
    }
  }
};

struct Dive {
  SearchTask t;
  SearchFinds finds;
  const std::uint64_t* tops;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::int32_t width = t.grid.blocks_x();
    const std::size_t poses = static_cast<std::size_t>(t.heading_count) * kBlockPoses;
    for (std::size_t n = me.first(); n < poses; n += me.stride()) {
      const std::size_t heading = n / kBlockPoses;
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
  Blocks blocks;
  SearchFinds finds;
  std::int32_t first;  // heading
  std::size_t headings;
  Node* nodes;
  std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t per_heading = blocks.count();
    const std::uint32_t least = t.threshold(atomic_read(finds.best));
    for (std::size_t n = me.first(); n < headings * per_heading; n += me.stride()) {
      const std::int32_t k = t.heading(first + static_cast<std::int32_t>(n / per_heading));
      const std::size_t b = n % per_heading;
      if (swept(t, k, blocks.i(b), blocks.j(b), least) > 0)
        nodes[atomic_add(count, std::uint64_t{1})] = {k, blocks.i(b), blocks.j(b)};
    }
  }
};

/// Every pose of those blocks.
struct Descend {
  SearchTask t;
  SearchFinds finds;
  const Node* nodes;
  const std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t poses = static_cast<std::size_t>(*count) * kBlockPoses;
    for (std::size_t n = me.first(); n < poses; n += me.stride()) {
      const Node& node = nodes[n / kBlockPoses];
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
  std::size_t champions;
  std::uint64_t* out;
  std::uint64_t* count;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::uint32_t least = t.threshold(*finds.best);
    for (std::size_t c = me.first(); c < champions; c += me.stride()) {
      const std::uint64_t key = finds.champion[c];
      if (key != 0 && (key >> 40) >= least) out[atomic_add(count, std::uint64_t{1})] = key;
    }
  }
};

class CudaSearch final : public SearchBackend {
 public:
  CudaSearch(const SearchMap& map, int device)
      : queue_(device), champions_(map.free_blocks.size() * kTurnBins) {
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
    champion_.reserve(champions_);
    gathered_.reserve(champions_);
    counts_.reserve(2);
    nodes_.reserve(std::max(kNodes, map.free_blocks.size()));
    queue_.wait();
  }

  std::string name() const override { return queue_.name(); }

  void search(const SearchTask& asked, const SearchScan& scan,
              std::vector<std::uint64_t>& champions) override {
    queue_.use();
    SearchTask task = asked;
    task.grid = grid_;
    offsets_.from_host(scan.offsets, queue_);
    task.offsets = offsets_.data();
    const Blocks blocks{task.block_i, task.block_j, task.block_end_i - task.block_i,
                        task.block_end_j - task.block_j};
    const SearchFinds finds{best_.data(), champion_.data()};
    dive(task, blocks, finds);
    sweep(task, blocks, finds);
    std::uint64_t* count = counts_.data() + 1;
    launch(Reset{count}, 1, queue_);
    launch(Gather{task, finds, champions_, gathered_.data(), count}, blocks_for(champions_), queue_);
    const std::uint64_t found = counts_.to_host(2, queue_)[1];
    champions = gathered_.to_host(static_cast<std::size_t>(found), queue_);
  }

 private:
  void dive(const SearchTask& task, const Blocks& blocks, const SearchFinds& finds) {
    const std::size_t rounds = static_cast<std::size_t>((task.heading_count + kDiveStep - 1) / kDiveStep);
    tops_.reserve(rounds);
    launch(Clear{finds, champions_, tops_.data(), rounds}, blocks_for(champions_), queue_);
    launch(DiveSweep{task, blocks, rounds, tops_.data()}, blocks_for(rounds * blocks.count()), queue_);
    launch(Dive{task, finds, tops_.data()},
           blocks_for(static_cast<std::size_t>(task.heading_count) * kBlockPoses), queue_);
  }

  void sweep(const SearchTask& task, const Blocks& blocks, const SearchFinds& finds) {
    const std::size_t at_a_time = std::max<std::size_t>(1, nodes_.size() / blocks.count());
    const std::size_t headings = static_cast<std::size_t>(task.heading_count);
    for (std::size_t first = 0; first < headings; first += at_a_time) {
      const std::size_t here = std::min(at_a_time, headings - first);
      launch(Reset{counts_.data()}, 1, queue_);
      launch(
          Sweep{task, blocks, finds, static_cast<std::int32_t>(first), here, nodes_.data(), counts_.data()},
          blocks_for(here * blocks.count()), queue_);
      launch(Descend{task, finds, nodes_.data(), counts_.data()}, kDescendBlocks, queue_);
    }
  }

  /// How many nodes there are is known on the device alone.
  static constexpr unsigned kDescendBlocks = 1024;

  Queue queue_;
  std::size_t champions_;
  SearchGrid grid_;
  DeviceBuffer<std::uint8_t> cells_, windows_, free_cells_, free_blocks_;
  DeviceBuffer<Offset> offsets_;
  DeviceBuffer<std::uint32_t> best_;
  DeviceBuffer<std::uint64_t> champion_, gathered_, tops_, counts_;
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
