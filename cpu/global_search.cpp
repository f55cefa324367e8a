#include <atomic>
#include <cstring>

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

/// found(block_i, block_j, bound) for every free block of a heading whose bound reaches least().
template <class Least, class Found>
inline __attribute__((always_inline)) void sweep(const SearchTask& t, std::int32_t k, Looks& looks,
                                                 const Least& least, const Found& found) {
  const SearchPlane& windows = t.grid.windows;
  look_along(t, k, looks);
  for (std::int32_t j = t.block_j; j < t.block_end_j; ++j) {
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

class CpuSearch final : public SearchBackend {
 public:
  CpuSearch(const SearchMap& map, int threads)
      : map_(map), workers_(cpu::Workers::open(threads)), champions_(map.free_blocks.size() * kTurnBins) {}

  std::string name() const override { return workers_.name(); }

  void search(const SearchTask& asked, const SearchScan& scan,
              std::vector<std::uint64_t>& champions) override {
    SearchTask task = asked;
    task.grid = map_.view();
    task.offsets = scan.offsets.data();
    clear();
    best_ = 0;
    const SearchFinds finds{&best_, champions_.data()};
    dive(task, finds);
    for_each_heading(task.heading_count, [&](std::int32_t n, Looks& looks) PARLOC_SIMD_LOOP {
      const std::int32_t k = task.heading(n);
      sweep(
          task, k, looks, [&] { return task.threshold(atomic_read(finds.best)); },
          [&](std::int32_t i, std::int32_t j, std::uint32_t) { search_block(task, finds, k, i, j); });
    });
    champions.clear();
    const std::uint32_t least = task.threshold(best_);
    for (const std::uint64_t key : champions_)
      if (key != 0 && (key >> 40) >= least) champions.push_back(key);
  }

 private:
  void clear() {
    std::uint64_t* champion = champions_.data();
    cpu::parallel_blocks(champions_.size(), champions_.size() < cpu::kSmallLoop ? 1 : workers_.threads, 64,
                         [=](std::size_t begin, std::size_t end) PARLOC_SIMD_LOOP {
                           for (std::size_t c = begin; c < end; ++c) champion[c] = 0;
                         });
  }

  void dive(const SearchTask& task, const SearchFinds& finds) {
    const std::int32_t rounds = (task.heading_count + kDiveStep - 1) / kDiveStep;
    const std::int32_t width = task.grid.blocks_x();
    for_each_heading(rounds, [&](std::int32_t n, Looks& looks) PARLOC_SIMD_LOOP {
      const std::int32_t first = n * kDiveStep;
      const std::int32_t middle = first + kDiveStep / 2 < task.heading_count ? first + kDiveStep / 2 : first;
      std::uint64_t most = 0;
      sweep(
          task, task.heading(middle), looks,
          [&] {
            const auto bound = static_cast<std::uint32_t>(most >> 32);
            return bound > task.least ? bound : task.least;
          },
          [&](std::int32_t i, std::int32_t j, std::uint32_t bound) {
            const std::uint64_t key = block_key(bound, static_cast<std::uint32_t>(j * width + i));
            if (key > most) most = key;
          });
      if (most == 0) return;
      const auto block = static_cast<std::int32_t>(block_of_key(most));
      for (std::int32_t m = first; m < first + kDiveStep && m < task.heading_count; ++m)
        search_block(task, finds, task.heading(m), block % width, block / width);
    });
  }

  /// Headings differ much in their work: whoever is done takes the next.
  template <class Work>
  void for_each_heading(std::int32_t count, const Work& work) const {
    std::atomic<std::int32_t> next{0};
    cpu::parallel_blocks(static_cast<std::size_t>(workers_.threads), workers_.threads, 1,
                         [&](std::size_t, std::size_t) PARLOC_SIMD_LOOP {
                           Looks looks;
                           for (std::int32_t n; (n = next.fetch_add(1, std::memory_order_relaxed)) < count;)
                             work(n, looks);
                         });
  }

  const SearchMap& map_;
  cpu::Workers workers_;
  std::vector<std::uint64_t> champions_;
  std::uint32_t best_ = 0;
};

}  // namespace

std::unique_ptr<SearchBackend> make_cpu_search(const SearchMap& map, int threads) {
  return std::make_unique<CpuSearch>(map, threads);
}

}  // namespace parloc
