#include <algorithm>
#include <cstring>
#include <memory>

#include "common/search/search_backend.h"
#include "cpu/parallel.h"

namespace parloc {
namespace {

/// 64 sums side by side, as two halves.
constexpr std::int32_t kLanes = kSweepLanes, kHalf = kLanes / 2;
static_assert(kLanes == kBlockPoses, "a strip of blocks and the poses of one block are summed alike");
typedef std::uint8_t Bytes __attribute__((vector_size(kHalf)));
typedef std::uint16_t Words __attribute__((vector_size(2 * kHalf)));

constexpr std::int32_t kMostBeams = 256;
static_assert(kMostBeams * kMostValue <= 0xffff, "a sum fits in 16 bits");
static_assert(4 * kMostValue <= 0xff, "four values fit in 8 bits");

inline __attribute__((always_inline)) std::int32_t limited(std::int32_t x, std::int32_t low,
                                                           std::int32_t high) {
  return x < low ? low : x > high ? high : x;
}

struct Sums {
  alignas(64) std::uint16_t lane[kLanes];
};

/// Adds up 64 bytes of each beam; load(beam, bytes) fetches them. False as soon as none of the sums can reach
/// `least`.
template <class Load>
inline __attribute__((always_inline)) bool sum_lanes(std::int32_t beams, std::uint32_t least,
                                                     const Load& load, Sums& sums) {
  Words low{}, high{};
  for (std::int32_t b = 0; b < beams;) {
    const std::int32_t stop = b + 20 < beams ? b + 20 : beams;
    while (b < stop) {
      Bytes four_low{}, four_high{};
      for (const std::int32_t end = b + 4 < beams ? b + 4 : beams; b < end; ++b) {
        Bytes one[2];
        load(b, reinterpret_cast<std::uint8_t*>(one));
        four_low += one[0];
        four_high += one[1];
      }
      low += __builtin_convertvector(four_low, Words);
      high += __builtin_convertvector(four_high, Words);
    }
    const std::uint32_t rest = kMostValue * static_cast<std::uint32_t>(beams - b);
    const auto needed = static_cast<std::uint16_t>(least > rest ? least - rest : 0u);
    const Words limit = Words{} + needed;
    const auto reaches = (low >= limit) | (high >= limit);
    std::uint64_t any[sizeof reaches / 8];
    std::memcpy(any, &reaches, sizeof reaches);
    std::uint64_t some = 0;
    for (const std::uint64_t word : any) some |= word;
    if (some == 0) return false;
  }
  std::memcpy(sums.lane, &low, sizeof low);
  std::memcpy(sums.lane + kHalf, &high, sizeof high);
  return true;
}

/// Where a heading's beams look: windows, relative to a block's own place.
struct Looks {
  const std::uint8_t* plane[kMostBeams];
  Offset entry[kMostBeams];
  const std::uint8_t* row[kMostBeams];  // of the row of blocks at hand
};

void look_along(const SearchTask& t, std::int32_t k, Looks& looks) {
  const Offset* offset = t.offsets + std::int64_t{k} * t.beams;
  for (std::int32_t b = 0; b < t.beams; ++b) {
    looks.plane[b] = plane_of(t.grid, offset[b]);
    looks.entry[b] = entry_of(offset[b]);
  }
}

/// As many columns of blocks as are summed as a square, not row by row.
constexpr std::int32_t kNarrow = kBlockCells;
bool narrow(const SearchTask& t) {
  return t.block_end_i - t.block_i <= kNarrow;
}

/// found(block_i, block_j, bound) for every free block of a row whose bound reaches least().
template <class Least, class Found>
inline __attribute__((always_inline)) void sweep_row(const SearchTask& t, std::int32_t j, Looks& looks,
                                                     const Least& least, const Found& found) {
  const SearchPlane& windows = t.grid.windows;
  for (std::int32_t b = 0; b < t.beams; ++b)  // beyond the map are zeros
    looks.row[b] =
        looks.plane[b] + std::int64_t{limited(j + looks.entry[b].y, -1, windows.height)} * windows.stride;
  const std::uint8_t* free = t.grid.free_blocks + std::int64_t{j} * t.grid.blocks_x();
  for (std::int32_t i = t.block_i; i < t.block_end_i; i += kLanes) {
    Sums sums;
    const auto strip = [&](std::int32_t b, std::uint8_t* bytes) {
      std::memcpy(bytes, looks.row[b] + limited(i + looks.entry[b].x, -kLanes, windows.width), kLanes);
    };
    if (!sum_lanes(t.beams, least(), strip, sums)) continue;
    const std::int32_t lanes = t.block_end_i - i < kLanes ? t.block_end_i - i : kLanes;
    for (std::int32_t n = 0; n < lanes; ++n)
      if (sums.lane[n] >= least() && free[i + n] != 0) found(i + n, j, std::uint32_t{sums.lane[n]});
  }
}

/// The same for a few rows of a narrow task.
template <class Least, class Found>
inline __attribute__((always_inline)) void sweep_square(const SearchTask& t, std::int32_t j,
                                                        std::int32_t rows, const Looks& looks,
                                                        const Least& least, const Found& found) {
  const SearchPlane& windows = t.grid.windows;
  Sums sums;
  const auto square = [&](std::int32_t b, std::uint8_t* bytes) {
    const std::uint8_t* from = looks.plane[b] + limited(t.block_i + looks.entry[b].x, -kLanes, windows.width);
    for (std::int32_t row = 0; row < kNarrow; ++row) {
      const std::int32_t y = limited(j + row + looks.entry[b].y, -1, windows.height);
      std::memcpy(bytes + row * kNarrow, from + std::int64_t{y} * windows.stride, kNarrow);
    }
  };
  if (!sum_lanes(t.beams, least(), square, sums)) return;
  for (std::int32_t n = 0; n < rows * kNarrow; ++n) {
    const std::int32_t i = t.block_i + n % kNarrow, row = j + n / kNarrow;
    if (i < t.block_end_i && sums.lane[n] >= least() &&
        t.grid.free_blocks[std::int64_t{row} * t.grid.blocks_x() + i] != 0)
      found(i, row, std::uint32_t{sums.lane[n]});
  }
}

/// And for rows of any task, `rows` of them from j on; a few only if it is narrow.
template <class Least, class Found>
inline __attribute__((always_inline)) void sweep_rows(const SearchTask& t, std::int32_t j, std::int32_t rows,
                                                      Looks& looks, const Least& least, const Found& found) {
  if (narrow(t)) return sweep_square(t, j, rows, looks, least, found);
  for (std::int32_t row = j; row < j + rows; ++row) sweep_row(t, row, looks, least, found);
}

/// Scores all poses of a block at one heading and records the best.
inline __attribute__((always_inline)) void search_block(const SearchTask& t, const SearchFinds& finds,
                                                        std::int32_t k, std::int32_t block_i,
                                                        std::int32_t block_j) {
  const SearchPlane& cells = t.grid.cells;
  const Offset* offset = t.offsets + std::int64_t{k} * t.beams;
  const std::int32_t i = block_i * kBlockCells, j = block_j * kBlockCells;
  const std::uint32_t least = t.threshold(atomic_read(finds.best));
  Sums sums;
  const auto square = [&](std::int32_t b, std::uint8_t* bytes) {
    const std::int32_t x = limited(i + offset[b].x, -kBlockCells, cells.width);
    const std::int32_t y = limited(j + offset[b].y, -kBlockCells, cells.height);
    const std::uint8_t* from = cells.first + std::int64_t{y} * cells.stride + x;
    for (std::int32_t row = 0; row < kBlockCells; ++row)
      std::memcpy(bytes + row * kBlockCells, from + row * cells.stride, kBlockCells);
  };
  if (!sum_lanes(t.beams, least, square, sums)) return;
  std::int32_t best = -1;
  for (std::int32_t n = 0; n < kLanes; ++n) {  // the first among equals is also the first on the lattice
    const std::uint32_t other = best < 0 ? least : sums.lane[best] + 1u;
    if (sums.lane[n] >= other && pose_counts(t, i + n % kBlockCells, j + n / kBlockCells)) best = n;
  }
  if (best >= 0) record_pose(t, finds, k, i + best % kBlockCells, j + best / kBlockCells, sums.lane[best]);
}

/// A block that a sweep found. Its bound is kept because the threshold may rise before it is its turn.
struct Found {
  std::uint16_t bound, heading;  // the heading is the task's n-th
  std::uint32_t block;
};

class CpuSearch final : public SearchBackend {
 public:
  CpuSearch(const SearchMap& map, int threads)
      : map_(map),
        workers_(cpu::Workers::open(threads)),
        champions_(map.free_blocks.size() * kTurnBins),
        queue_(std::make_unique_for_overwrite<Found[]>(std::max(kMostFound, map.free_blocks.size()))) {}

  std::string name() const override { return workers_.name(); }

  void begin(const SearchTask& asked, const SearchScan& scan) override {
    task_ = asked;
    task_.grid = map_.view();
    task_.offsets = scan.offsets.data();
    tops_.assign(static_cast<std::size_t>((task_.heading_count + kDiveStep - 1) / kDiveStep), 0);
    best_ = 0;
    found_ = 0;
  }

  void clear(SearchItems rows) override {
    std::uint64_t* champion = champions_.data();
    const SearchTask& task = task_;
    const bool few = rows.count * static_cast<std::size_t>(slots_of_row()) < cpu::kSmallLoop;
    cpu::parallel_blocks(rows.count, few ? 1 : workers_.threads, 1,
                         [=, &task](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                           for (std::size_t r = rows.first + begin; r < rows.first + end; ++r) {
                             std::uint64_t* slot = champion + first_slot(task, r);
                             std::fill(slot, slot + (task.block_end_i - task.block_i) * kTurnBins, 0);
                           }
                         });
  }

  void sweep_dive(SearchItems rows) override {
    const SearchTask& task = task_;
    std::uint64_t* tops = tops_.data();
    const std::int32_t width = task.grid.blocks_x();
    const auto heading_of = [&](std::size_t round) {
      const auto first = static_cast<std::int32_t>(round) * kDiveStep;
      return task.heading(first + kDiveStep / 2 < task.heading_count ? first + kDiveStep / 2 : first);
    };
    for_each_row(rows, heading_of,
                 [&](std::size_t round, std::int32_t j, std::int32_t few, Looks& looks) PARLOC_SIMD_LOOP {
                   std::uint64_t most = atomic_read(tops + round);
                   sweep_rows(
                       task, j, few, looks,
                       [&] {
                         const auto bound = static_cast<std::uint32_t>(most >> 32);
                         return bound > task.least ? bound : task.least;
                       },
                       [&](std::int32_t i, std::int32_t row, std::uint32_t bound) {
                         const std::uint64_t key =
                             block_key(bound, static_cast<std::uint32_t>(row * width + i));
                         if (key > most) most = key;
                       });
                   atomic_raise(tops + round, most);
                 });
  }

  void dive(SearchItems headings) override {
    const SearchTask& task = task_;
    const SearchFinds finds{&best_, champions_.data()};
    const std::uint64_t* tops = tops_.data();
    const std::int32_t width = task.grid.blocks_x();
    for_each_of(headings, [&](std::size_t n) PARLOC_SIMD_LOOP {
      const std::uint64_t top = tops[n / kDiveStep];
      if (top == 0) return;
      const auto block = static_cast<std::int32_t>(block_of_key(top));
      search_block(task, finds, task.heading(static_cast<std::int32_t>(n)), block % width, block / width);
    });
  }

  void sweep(SearchItems rows) override {
    const SearchTask& task = task_;
    const std::uint32_t least = task.threshold(best_);
    const std::int32_t width = task.grid.blocks_x();
    std::uint64_t* count = &found_;
    Found* queue = queue_.get();
    const auto heading_of = [&](std::size_t n) { return task.heading(static_cast<std::int32_t>(n)); };
    for_each_row(rows, heading_of,
                 [&](std::size_t n, std::int32_t j, std::int32_t few, Looks& looks) PARLOC_SIMD_LOOP {
                   sweep_rows(
                       task, j, few, looks, [&] { return least; },
                       [&](std::int32_t i, std::int32_t row, std::uint32_t bound) {
                         queue[atomic_add(count, std::uint64_t{1})] = {
                             static_cast<std::uint16_t>(bound), static_cast<std::uint16_t>(n),
                             static_cast<std::uint32_t>(row * width + i)};
                       });
                 });
  }

  std::size_t found() override { return static_cast<std::size_t>(found_); }
  void forget_found() override { found_ = 0; }

  void search_found(SearchItems found) override {
    const SearchTask& task = task_;
    const SearchFinds finds{&best_, champions_.data()};
    const Found* queue = queue_.get();
    const auto width = static_cast<std::uint32_t>(task.grid.blocks_x());
    for_each_of(found, [&](std::size_t n) PARLOC_SIMD_LOOP {
      const Found& f = queue[n];
      if (f.bound < task.threshold(atomic_read(finds.best))) return;
      search_block(task, finds, task.heading(f.heading), static_cast<std::int32_t>(f.block % width),
                   static_cast<std::int32_t>(f.block / width));
    });
  }

  void wait() override {}

  void gather(SearchItems rows, std::vector<std::uint64_t>& champions) override {
    const std::uint32_t least = task_.threshold(best_);
    for (std::size_t r = rows.first; r < rows.end(); ++r) {
      const std::uint64_t* slot = champions_.data() + first_slot(task_, r);
      for (std::int32_t n = 0; n < slots_of_row(); ++n)
        if (slot[n] != 0 && (slot[n] >> 40) >= least) champions.push_back(slot[n]);
    }
  }

 private:
  std::int32_t slots_of_row() const { return (task_.block_end_i - task_.block_i) * kTurnBins; }
  static std::size_t first_slot(const SearchTask& t, std::size_t row) {
    const std::int64_t block = (t.block_j + static_cast<std::int64_t>(row)) * t.grid.blocks_x() + t.block_i;
    return static_cast<std::size_t>(block * kTurnBins);
  }

  /// work(item) for each. They differ much in their work: whoever is done takes the next few.
  template <class Work>
  void for_each_of(SearchItems items, const Work& work) const {
    constexpr std::size_t few = 64;
    cpu::parallel_tasks((items.count + few - 1) / few, items.count < kSmallWork ? 1 : workers_.threads,
                        [&](std::size_t task) PARLOC_SIMD_LOOP {
                          const std::size_t first = items.first + task * few;
                          for (std::size_t n = first; n < std::min(first + few, items.end()); ++n) work(n);
                        });
  }

  /// work(n, row of the map, how many from there on, looks) for all rows of the task, at heading_of(n).
  template <class Heading, class Work>
  void for_each_row(SearchItems items, const Heading& heading_of, const Work& work) const {
    const SearchTask& t = task_;
    const auto rows = static_cast<std::size_t>(t.block_end_j - t.block_j);
    const auto strips = static_cast<std::size_t>((t.block_end_i - t.block_i + kLanes - 1) / kLanes);
    const std::size_t few = kSmallWork / 8 / strips + 1, at_once = narrow(t) ? kNarrow : 1;
    const int threads = items.count * strips < kSmallWork ? 1 : workers_.threads;
    cpu::parallel_tasks((items.count + few - 1) / few, threads, [&](std::size_t task) PARLOC_SIMD_LOOP {
      Looks looks;
      std::size_t looks_at = ~std::size_t{0};
      const std::size_t end = std::min(items.first + (task + 1) * few, items.end());
      for (std::size_t item = items.first + task * few, next; item < end; item = next) {
        const std::size_t n = item / rows;
        if (n != looks_at) look_along(t, heading_of(n), looks);
        looks_at = n;
        next = std::min({item + at_once, (n + 1) * rows, end});
        work(n, t.block_j + static_cast<std::int32_t>(item % rows), static_cast<std::int32_t>(next - item),
             looks);
      }
    });
  }

  /// Strips or blocks below which one thread does them all.
  static constexpr std::size_t kSmallWork = 512;

  const SearchMap& map_;
  cpu::Workers workers_;
  std::vector<std::uint64_t> champions_;
  std::unique_ptr<Found[]> queue_;  // not initialised: only what is used becomes memory
  SearchTask task_;
  std::vector<std::uint64_t> tops_;  // of the dive, by round: the block with the highest bound
  std::uint32_t best_ = 0;
  std::uint64_t found_ = 0;
};

}  // namespace

std::unique_ptr<SearchBackend> make_cpu_search(const SearchMap& map, int threads) {
  return std::make_unique<CpuSearch>(map, threads);
}

}  // namespace parloc
