#include "common/map/rays/skip_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "common/error.h"
#include "common/map/map_limits.h"

namespace parloc {
namespace {

constexpr std::int32_t kMostLines = 255;

// ---- one plane for all directions -------------------------------------------------------------------

std::uint8_t one_more(std::uint8_t d) {
  return static_cast<std::uint8_t>(d + (d < 255 ? 1 : 0));
}

std::uint8_t least(std::uint8_t a, std::uint8_t b) {
  return b < a ? b : a;
}

// One more than the least of the three neighbours in `row`, a finished padded row, into `reach`. No cell
// depends on another, so this vectorises; only the scans along the row below are serial.
void reach_through(const std::uint8_t* row, std::int32_t width, std::uint8_t* reach) {
  for (std::int32_t i = 0; i < width; ++i) reach[i] = one_more(least(least(row[i - 1], row[i]), row[i + 1]));
}

/// Chebyshev distance from each cell to the nearest blocking one or to the ring, at most 255; `first` is cell
/// (0, 0) of a padded plane of zeros.
void chebyshev_distances(const std::uint8_t* blocks, std::int32_t width, std::int32_t height,
                         std::uint8_t* first) {
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(width) + 2;
  std::vector<std::uint8_t> reach(static_cast<std::size_t>(width));
  for (std::int32_t j = 0; j < height; ++j) {  // from below and from the left
    std::uint8_t* row = first + j * stride;
    const std::uint8_t* blocked = blocks + static_cast<std::ptrdiff_t>(j) * width;
    reach_through(row - stride, width, reach.data());
    for (std::int32_t i = 0; i < width; ++i) reach[i] = blocked[i] != 0 ? std::uint8_t{0} : reach[i];
    std::uint8_t left = 0;
    for (std::int32_t i = 0; i < width; ++i) row[i] = left = least(reach[i], one_more(left));
  }
  for (std::int32_t j = height - 1; j >= 0; --j) {  // from above and from the right
    std::uint8_t* row = first + j * stride;
    reach_through(row + stride, width, reach.data());
    std::uint8_t right = 0;
    for (std::int32_t i = width - 1; i >= 0; --i)
      row[i] = right = least(least(row[i], reach[i]), one_more(right));
  }
}

/// All cells nearer than d are free. In k columns a ray of any direction climbs at most k + 1 rows, and where
/// it meets a corner one more: with k = d - 2 it stays among them.
void lines_of_distances(ZeroedVector<std::uint8_t>& plane) {
  for (std::uint8_t& d : plane) d = d > 2 ? static_cast<std::uint8_t>(d - 2) : least(d, 1);
}

// ---- one plane per sector ---------------------------------------------------------------------------

/// A ray's float32 arithmetic may place it this far from where geometry does; the table is made for both.
constexpr double kMargin_cells = 0.05;

/// The grid as an octant sees it: a counts cells along the main axis in the ray's sense, b along the other.
/// Cell (a, b) is at origin + a * main + b * other of an array.
struct View {
  std::ptrdiff_t origin, main, other;
};

/// `pad`: width of the ring around the array's grid.
View view_of(std::int32_t octant, std::ptrdiff_t width, std::ptrdiff_t height, std::ptrdiff_t pad) {
  const bool left = (octant & 1) != 0, down = (octant & 2) != 0, steep = (octant & 4) != 0;
  const std::ptrdiff_t stride = width + 2 * pad;
  const std::ptrdiff_t x = left ? -1 : 1, y = down ? -stride : stride;
  const std::ptrdiff_t origin = ((down ? height - 1 : 0) + pad) * stride + (left ? width - 1 : 0) + pad;
  return {origin, steep ? y : x, steep ? x : y};
}

/// How far up from each cell its column is free: a stretch of it is, if its lowest cell sees as far as that.
/// Outside the grid everything blocks.
class Columns {
 public:
  Columns(const std::uint8_t* blocks, const View& view, std::int32_t main_size, std::int32_t other_size)
      : height_(static_cast<std::size_t>(other_size) + kMostLines + 2),
        free_(static_cast<std::size_t>(main_size) * height_) {
    for (std::int32_t a = 0; a < main_size; ++a) {
      const std::uint8_t* cell = blocks + view.origin + a * view.main;
      std::uint8_t* free = free_.data() + static_cast<std::size_t>(a) * height_;
      std::uint8_t above = 0;
      for (std::int32_t b = other_size - 1; b >= 0; --b)
        free[b] = above = cell[b * view.other] != 0 ? std::uint8_t{0} : one_more(above);
    }
  }
  /// Bytes from a column to the next. Rows up to kMostLines + 1 beyond the grid may be asked for.
  std::size_t height() const { return height_; }
  /// Cells that are free from (a, b) upwards, itself included; at most 255.
  const std::uint8_t* free_from(std::int32_t a, std::int32_t b = 0) const {
    return free_.data() + static_cast<std::size_t>(a) * height_ + b;
  }

 private:
  std::size_t height_;
  std::vector<std::uint8_t> free_;
};

/// The rows, relative to its own, that a ray of a slope interval can be in when it is k columns on: where
/// the lowest of them is in Columns, seen from the ray's own cell, and how many there are.
struct Rows {
  std::size_t lowest[kMostLines];
  std::int32_t count[kMostLines];
  Rows(std::int32_t part, std::int32_t slopes, std::size_t height) {
    const double flattest = static_cast<double>(part) / slopes,
                 steepest = static_cast<double>(part + 1) / slopes;
    for (std::int32_t k = 0; k < kMostLines; ++k) {
      const double low = std::floor(std::max(0.0, flattest * (k - 1) - kMargin_cells));
      const double high = std::floor(1.0 + steepest * (k + 1) + kMargin_cells);
      lowest[k] = static_cast<std::size_t>(k) * height + static_cast<std::size_t>(low);
      count[k] = static_cast<std::int32_t>(high - low) + 1;  // at most 255 / 2 + 3
    }
  }
};

void fill_sector(const Columns& columns, const Rows& rows, std::int32_t main_size, std::int32_t other_size,
                 const View& out, std::uint8_t* plane) {
  // What both cells (a + 1, b) and (a + 1, b + 1) promise holds from (a, b) too, one line later: `next` are
  // their lines, so that few columns are looked at twice.
  std::vector<std::uint8_t> next(static_cast<std::size_t>(other_size) + 1, 0), here(next);
  for (std::int32_t a = main_size - 1; a >= 0; --a) {
    const std::uint8_t* column = columns.free_from(a);
    const std::int32_t most = std::min(kMostLines, main_size - a);
    for (std::int32_t b = 0; b < other_size; ++b) {
      here[b] = 0;
      if (column[b] == 0) continue;
      const std::uint8_t* from = column + b;
      const auto is_free = [&](std::int32_t k) { return from[rows.lowest[k]] >= rows.count[k]; };
      std::int32_t lines = 0;
      if (is_free(0)) {
        lines = std::min(most, 1 + std::min<std::int32_t>(next[b], next[b + 1]));
        while (lines < most && is_free(lines)) ++lines;
      }
      here[b] = static_cast<std::uint8_t>(lines);
      plane[out.origin + a * out.main + b * out.other] = static_cast<std::uint8_t>(std::max(lines, 1));
    }
    std::swap(here, next);
  }
}

/// All sectors of an octant.
void fill_octant(const std::uint8_t* blocks, std::int32_t width, std::int32_t height, std::int32_t octant,
                 SkipField& field) {
  const bool steep = (octant & 4) != 0;
  const std::int32_t main_size = steep ? height : width, other_size = steep ? width : height;
  const Columns columns(blocks, view_of(octant, width, height, 0), main_size, other_size);
  for (std::int32_t part = 0; part < field.planes.slopes; ++part)
    fill_sector(columns, Rows(part, field.planes.slopes, columns.height()), main_size, other_size,
                view_of(octant, width, height, 1),
                field.lines.data() + static_cast<std::size_t>(field.planes.bytes) *
                                         static_cast<std::size_t>(octant * field.planes.slopes + part));
}

/// The plane behind those of the sectors: the least of them, of cells [from, to) of a plane.
void fill_least(SkipField& field, std::size_t from, std::size_t to) {
  const std::size_t plane = static_cast<std::size_t>(field.planes.bytes);
  const std::int32_t sectors = 8 * field.planes.slopes;
  std::uint8_t* all = field.lines.data() + plane * static_cast<std::size_t>(sectors);
  for (std::int32_t s = 0; s < sectors; ++s) {
    const std::uint8_t* sector = field.lines.data() + plane * static_cast<std::size_t>(s);
    for (std::size_t c = from; c < to; ++c) all[c] = s == 0 ? sector[c] : least(all[c], sector[c]);
  }
}

/// task(k) for each k in [0, count), on so many threads. The first exception is thrown again.
template <class Task>
void run_tasks(std::size_t count, int threads, const Task& task) {
  std::atomic<std::size_t> taken = 0;
  std::exception_ptr fault;
  std::mutex one_fault;
  const auto work = [&] {
    for (std::size_t k = taken++; k < count; k = taken++) try {
        task(k);
      } catch (...) {
        const std::lock_guard lock(one_fault);
        if (!fault) fault = std::current_exception();
      }
  };
  {
    std::vector<std::jthread> team;
    const std::size_t wanted =
        threads > 0 ? static_cast<std::size_t>(threads) : std::thread::hardware_concurrency();
    for (std::size_t t = 1; t < std::min(wanted, count); ++t) team.emplace_back(work);
    work();
  }
  if (fault) std::rethrow_exception(fault);
}

void check(std::int32_t width, std::int32_t height) {
  if (width < 1 || height < 1 || width > kMaxMapSide || height > kMaxMapSide) {
    throw Error(ErrorKind::internal, "skip field of " + std::to_string(width) + " x " +
                                         std::to_string(height) + " cells: expected sides from 1 to " +
                                         std::to_string(kMaxMapSide));
  }
}

}  // namespace

SkipField skip_field(const std::uint8_t* blocks, std::int32_t width, std::int32_t height,
                     std::size_t most_bytes, int threads) {
  check(width, height);
  const std::size_t plane = (static_cast<std::size_t>(width) + 2) * (static_cast<std::size_t>(height) + 2);
  SkipField field;
  most_bytes = std::min(most_bytes, std::size_t{0x7fffffff} - kSkipFieldTail);  // lanes look up at 32 bits
  const auto fits = [&](std::int32_t slopes, std::size_t most) {
    return plane * static_cast<std::size_t>(8 * slopes + 1) <= most;
  };
  if (fits(kSlopes, std::min(most_bytes, kMostFineBytes)))
    field.planes = {static_cast<std::int32_t>(plane), kSlopes};
  else if (fits(kSlopes / 2, most_bytes))
    field.planes = {static_cast<std::int32_t>(plane), kSlopes / 2};
  if (field.planes.bytes == 0) {
    field.lines.resize(plane + kSkipFieldTail);
    chebyshev_distances(blocks, width, height, field.lines.data() + width + 3);
    lines_of_distances(field.lines);
    return field;
  }
  field.lines.resize(plane * static_cast<std::size_t>(8 * field.planes.slopes + 1) + kSkipFieldTail);
  run_tasks(8, threads, [&](std::size_t octant) {
    fill_octant(blocks, width, height, static_cast<std::int32_t>(octant), field);
  });
  constexpr std::size_t kPart = std::size_t{1} << 16;  // of a plane: 33 of them fit into a cache
  run_tasks((plane + kPart - 1) / kPart, threads,
            [&](std::size_t k) { fill_least(field, k * kPart, std::min(plane, (k + 1) * kPart)); });
  return field;
}

}  // namespace parloc
