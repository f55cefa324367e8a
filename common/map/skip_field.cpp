#include "common/map/skip_field.h"

#include <string>

#include "common/error.h"
#include "common/map/map_limits.h"

namespace parloc {
namespace {

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

}  // namespace

std::vector<std::uint8_t> skip_field(const std::uint8_t* blocks, std::int32_t width, std::int32_t height) {
  if (width < 1 || height < 1 || width > kMaxMapSide || height > kMaxMapSide) {
    throw Error(ErrorKind::internal, "skip field of " + std::to_string(width) + " x " +
                                         std::to_string(height) + " cells: expected sides from 1 to " +
                                         std::to_string(kMaxMapSide));
  }
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(width) + 2;
  const std::size_t padded = static_cast<std::size_t>(stride) * (static_cast<std::size_t>(height) + 2);
  std::vector<std::uint8_t> field(padded + kSkipFieldTail, 0);
  std::vector<std::uint8_t> reach(static_cast<std::size_t>(width));
  std::uint8_t* const first = field.data() + stride + 1;  // cell (0, 0)

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
  return field;
}

}  // namespace parloc
