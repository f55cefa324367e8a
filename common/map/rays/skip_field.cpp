#include "common/map/rays/skip_field.h"

#include <algorithm>
#include <cmath>
#include <string>
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
void lines_of_distances(std::vector<std::uint8_t>& plane) {
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

/// Answers whether a stretch of a column (one a, several b) is free. Outside the grid everything blocks.
class Columns {
 public:
  Columns(const std::uint8_t* blocks, const View& view, std::int32_t main_size, std::int32_t other_size)
      : main_size_(main_size),
        other_size_(other_size),
        height_(static_cast<std::size_t>(other_size) + 1),
        before_(static_cast<std::size_t>(main_size) * height_) {
    for (std::int32_t a = 0; a < main_size; ++a) {
      const std::uint8_t* cell = blocks + view.origin + a * view.main;
      std::uint16_t* before = before_.data() + static_cast<std::size_t>(a) * height_;
      for (std::int32_t b = 0; b < other_size; ++b)
        before[b + 1] = static_cast<std::uint16_t>(before[b] + (cell[b * view.other] != 0 ? 1 : 0));
    }
  }
  /// Rows low to high, both included; low and high at least 0.
  bool free(std::int32_t a, std::int32_t low, std::int32_t high) const {
    if (a >= main_size_ || high >= other_size_) return false;
    const std::uint16_t* before = before_.data() + static_cast<std::size_t>(a) * height_;
    return before[low] == before[high + 1];
  }

 private:
  std::int32_t main_size_, other_size_;
  std::size_t height_;
  std::vector<std::uint16_t> before_;  // [a][b] blocking cells below row b
};

/// The rows, relative to its own, that a ray of a slope interval can be in when it is k columns on.
struct Rows {
  std::int32_t low[kMostLines + 1], high[kMostLines + 1];
  explicit Rows(std::int32_t part) {
    const double flattest = static_cast<double>(part) / kSlopes,
                 steepest = static_cast<double>(part + 1) / kSlopes;
    for (std::int32_t k = 0; k <= kMostLines; ++k) {
      low[k] = static_cast<std::int32_t>(std::floor(std::max(0.0, flattest * (k - 1) - kMargin_cells)));
      high[k] = static_cast<std::int32_t>(std::floor(1.0 + steepest * (k + 1) + kMargin_cells));
    }
  }
};

/// Lines from cell (a, b), whose own column's stretch is free; `known` of them are known already.
std::int32_t lines_from(const Columns& columns, const Rows& rows, std::int32_t a, std::int32_t b,
                        std::int32_t known) {
  std::int32_t k = known;
  while (k < kMostLines && columns.free(a + k, b + rows.low[k], b + rows.high[k])) ++k;
  return k;
}

void fill_sector(const Columns& columns, const Rows& rows, std::int32_t main_size, std::int32_t other_size,
                 const View& out, std::uint8_t* plane) {
  // What both cells (a + 1, b) and (a + 1, b + 1) promise holds from (a, b) too, one line later: `next` are
  // their lines, so that few columns are looked at twice.
  std::vector<std::int32_t> next(static_cast<std::size_t>(other_size) + 1, 0), here(next);
  for (std::int32_t a = main_size - 1; a >= 0; --a) {
    for (std::int32_t b = 0; b < other_size; ++b) {
      std::int32_t lines = 0;
      if (columns.free(a, b + rows.low[0], b + rows.high[0]))
        lines = lines_from(columns, rows, a, b, std::min(kMostLines, 1 + std::min(next[b], next[b + 1])));
      here[b] = lines;
      if (columns.free(a, b, b))
        plane[out.origin + a * out.main + b * out.other] = static_cast<std::uint8_t>(std::max(lines, 1));
    }
    std::swap(here, next);
  }
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
                     std::size_t most_bytes) {
  check(width, height);
  const std::size_t plane = (static_cast<std::size_t>(width) + 2) * (static_cast<std::size_t>(height) + 2);
  SkipField field;
  if (plane * (kSectors + 1) > most_bytes) {
    field.lines.assign(plane + kSkipFieldTail, 0);
    chebyshev_distances(blocks, width, height, field.lines.data() + width + 3);
    lines_of_distances(field.lines);
    return field;
  }
  field.plane = static_cast<std::int32_t>(plane);
  field.lines.assign(plane * (kSectors + 1) + kSkipFieldTail, 0);
  for (std::int32_t octant = 0; octant < 8; ++octant) {
    const bool steep = (octant & 4) != 0;
    const std::int32_t main_size = steep ? height : width, other_size = steep ? width : height;
    const Columns columns(blocks, view_of(octant, width, height, 0), main_size, other_size);
    for (std::int32_t part = 0; part < kSlopes; ++part)
      fill_sector(columns, Rows(part), main_size, other_size, view_of(octant, width, height, 1),
                  field.lines.data() + plane * static_cast<std::size_t>(octant * kSlopes + part));
  }
  std::uint8_t* all = field.lines.data() + plane * kSectors;
  std::copy_n(field.lines.data(), plane, all);
  for (std::size_t s = 1; s < kSectors; ++s) {
    const std::uint8_t* sector = field.lines.data() + plane * s;
    for (std::size_t c = 0; c < plane; ++c) all[c] = least(all[c], sector[c]);
  }
  return field;
}

}  // namespace parloc
