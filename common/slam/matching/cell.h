// A cell of a map in the making: how many beams came to it, how many of them ended there, and where. One
// 64-bit word, so that a beam is counted by one addition; integers, so that the order of beams does not
// matter (SPEC 9.5).
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

/// From the low bit: visits (16 bits), hits (12), sums of the end points' places in the cell, x and y
/// (18 each) [1/128 cell].
using CellWord = std::uint64_t;

constexpr int kHitShift = 16, kSumXShift = 28, kSumYShift = 46;
constexpr std::uint32_t kPlacesPerCell = 128;
/// Beams of one scan.
constexpr std::size_t kMostDrawnBeams = 1024;
/// Fields are halved from here on, and a scan adds at most kMostDrawnBeams to each: none runs over.
constexpr std::uint32_t kMostHits = 1024, kMostVisits = 32768;

PARLOC_HD std::uint32_t visits_of(CellWord w) {
  return static_cast<std::uint32_t>(w & 0xffffu);
}
PARLOC_HD std::uint32_t hits_of(CellWord w) {
  return static_cast<std::uint32_t>((w >> kHitShift) & 0xfffu);
}
PARLOC_HD std::uint32_t sum_x_of(CellWord w) {
  return static_cast<std::uint32_t>((w >> kSumXShift) & 0x3ffffu);
}
PARLOC_HD std::uint32_t sum_y_of(CellWord w) {
  return static_cast<std::uint32_t>(w >> kSumYShift);
}
PARLOC_HD CellWord cell_word(std::uint32_t visits, std::uint32_t hits, std::uint32_t x, std::uint32_t y) {
  return CellWord{visits} | (CellWord{hits} << kHitShift) | (CellWord{x} << kSumXShift) |
         (CellWord{y} << kSumYShift);
}

/// What a beam adds to a cell that it passes.
constexpr CellWord kPassed = 1;

/// What a beam adds to the cell where it ends; (x, y): where in the cell, in [0, 1).
PARLOC_HD CellWord ended_at(float x, float y) {
  const float last = static_cast<float>(kPlacesPerCell - 1);
  const float qx = max_of(min_of(floor_of(x * static_cast<float>(kPlacesPerCell)), last), 0.0f);
  const float qy = max_of(min_of(floor_of(y * static_cast<float>(kPlacesPerCell)), last), 0.0f);
  return cell_word(1, 1, static_cast<std::uint32_t>(qx), static_cast<std::uint32_t>(qy));
}

/// Mean place of the end points, in cells from the cell's corner. There must be hits.
struct MeanPlace {
  float x, y;
};
PARLOC_HD MeanPlace mean_place(CellWord w) {
  constexpr float kMiddle =
      0.5f / static_cast<float>(kPlacesPerCell);  // of the places that a sum counts as one
  const float per_hit = 1.0f / (static_cast<float>(hits_of(w)) * static_cast<float>(kPlacesPerCell));
  return {fused(static_cast<float>(sum_x_of(w)), per_hit, kMiddle),
          fused(static_cast<float>(sum_y_of(w)), per_hit, kMiddle)};
}

/// A wall for the scan matcher: more than a tenth of the beams that came to the cell ended there.
PARLOC_HD bool is_occupied(CellWord w) {
  return 10 * hits_of(w) > visits_of(w);
}

/// All fields halved once they are large: old evidence counts less, and nothing runs over.
PARLOC_HD CellWord aged(CellWord w) {
  if (hits_of(w) < kMostHits && visits_of(w) < kMostVisits) return w;
  return cell_word(visits_of(w) / 2, hits_of(w) / 2, sum_x_of(w) / 2, sum_y_of(w) / 2);
}

}  // namespace parloc
