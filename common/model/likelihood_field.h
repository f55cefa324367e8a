// The likelihood field (Thrun, Burgard & Fox, Probabilistic Robotics table 6.3; SPEC 3.4): a beam's
// log-likelihood is a look-up at its end point, from a table over the map made once.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/map/rays/ray_cast.h"
#include "common/math/portable.h"
#include "common/model/sensor_config.h"

namespace parloc {

constexpr int kCellPartBits = 7;
constexpr std::int32_t kCellParts = 1 << kCellPartBits;  // an end point is rounded to such a part of a cell
constexpr std::int32_t kLeastInTable = -32767;           // a table's least value, that of "far from any wall"
constexpr int kValueBits = 4;                            // bits that interpolation adds to those of the table

/// A particle as the field sees it: place and heading, in parts of a cell.
struct FieldPose {
  float u, v, c, s;
};

/// Where an end point falls: its cell's place in the table, and how far it is beyond it in x (low half) and y
/// (high half) [parts].
struct FieldPlace {
  std::int32_t at;
  std::uint32_t parts;
};

/// Log-likelihood of an end point by cell: log p(D) - log p(0), 0 on a wall, least beyond the distance cap;
/// in 16-bit units of a 32767th of the least. Entry: a cell's own value (low half) and that of the cell above
/// it, so that the four around an end point lie side by side. `entries` points at cell (0, 0) of a padded
/// array (table_size()) whose ring holds the value of "off the map".
struct LikelihoodField {
  const std::uint32_t* entries = nullptr;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t stride = 0;
  /// Bilinear: cells are told apart by their middles, and parts of them count. Nearest: by their corners, and
  /// parts do not count.
  FieldLookup lookup = FieldLookup::bilinear;
  float unit_nat = 0;  ///< Of a value().

  /// u0, v0 [cells]
  PARLOC_HD FieldPose pose(float u0, float v0, const SinCos& h) const {
    constexpr float kParts = kCellParts;
    const float shift = lookup == FieldLookup::bilinear ? -0.5f * kParts : 0.0f;
    return {fused(u0, kParts, shift), fused(v0, kParts, shift), h.cos * kParts, h.sin * kParts};
  }

  /// Of an end point [cells, base frame]. Off the map: in the ring.
  PARLOC_HD FieldPlace place(const FieldPose& p, float end_x, float end_y) const {
    constexpr float kParts = kCellParts;
    const float u = base_to_grid_x(p.u, p.c, p.s, end_x, end_y);
    const float v = base_to_grid_y(p.v, p.c, p.s, end_x, end_y);
    const std::int32_t i = whole_of(min_of(max_of(u, -kParts), static_cast<float>(width) * kParts));
    const std::int32_t j = whole_of(min_of(max_of(v, -kParts), static_cast<float>(height) * kParts));
    const std::int32_t counts = lookup == FieldLookup::bilinear ? kCellParts - 1 : 0;
    return {(j >> kCellPartBits) * stride + (i >> kCellPartBits),
            static_cast<std::uint32_t>(i & counts) | static_cast<std::uint32_t>(j & counts) << 16};
  }

  /// From the entries at a place and behind it. Exact but for the last rounding.
  PARLOC_HD static std::int32_t value(std::uint32_t left, std::uint32_t right, std::uint32_t parts) {
    const std::int32_t a = static_cast<std::int32_t>(parts & 0xffffu);
    const std::int32_t b = static_cast<std::int32_t>(parts >> 16);
    const std::int32_t on_left = low_half(left) * kCellParts + b * (high_half(left) - low_half(left));
    const std::int32_t on_right = low_half(right) * kCellParts + b * (high_half(right) - low_half(right));
    constexpr int kDropped = 2 * kCellPartBits - kValueBits;
    return (on_left * kCellParts + a * (on_right - on_left) + (1 << (kDropped - 1))) >> kDropped;
  }

  PARLOC_HD std::int32_t value_at(const FieldPlace& p) const {
    return value(entries[p.at], entries[p.at + 1], p.parts);
  }

 private:
  PARLOC_HD static std::int32_t low_half(std::uint32_t entry) {
    return static_cast<std::int32_t>(entry << 16) >> 16;
  }
  PARLOC_HD static std::int32_t high_half(std::uint32_t entry) {
    return static_cast<std::int32_t>(entry) >> 16;
  }
};

/// log p(D) - log p(0) of a squared distance in cells: 0 on a wall, least from the distance cap on.
struct DistanceLikelihood {
  double squared_cell_m2;
  double squared_cap_m2;
  double variance_m2;
  float peak, floor;  // densities: of a hit on a wall, and of anything [1/m]
  float log_at_wall;
  float least = 0;  ///< From the cap on.

  PARLOC_HD float operator()(std::uint32_t squared_cells) const {
    const double squared_m2 = squared_cell_m2 * static_cast<double>(squared_cells);
    const double capped_m2 = squared_m2 < squared_cap_m2 ? squared_m2 : squared_cap_m2;
    const float exponent = static_cast<float>(-0.5 * capped_m2 / variance_m2);
    return portable_log(fused(peak, portable_exp(exponent), floor)) - log_at_wall;
  }
  /// As a table holds it.
  PARLOC_HD std::int32_t in_table(std::uint32_t squared_cells) const {
    const float units_per_nat = least < 0.0f ? static_cast<float>(kLeastInTable) / least : 0.0f;
    return whole_of((*this)(squared_cells)*units_per_nat);
  }
  float unit_nat() const { return least / static_cast<float>(kLeastInTable * (1 << kValueBits)); }
};

constexpr std::uint32_t kOffMap = 0xffffffffu;  // squared distance of what is off the map

inline DistanceLikelihood bind_distance(const SensorConfig& c, double resolution_m, double range_max_m) {
  const double cap_m = c.laser_likelihood_max_dist;
  const float peak = static_cast<float>(c.z_hit * 0.39894228040143267794 / c.sigma_hit);
  const float floor = static_cast<float>(c.z_rand / range_max_m);
  DistanceLikelihood likelihood{
      resolution_m * resolution_m, cap_m * cap_m, c.sigma_hit * c.sigma_hit, peak, floor,
      portable_log(peak + floor)};
  likelihood.least = likelihood(kOffMap);
  return likelihood;
}

/// Entries of a table: (height + 2) rows of (width + 2), and one so that the last has one behind it.
inline std::size_t table_size(std::int32_t width, std::int32_t height) {
  return (static_cast<std::size_t>(width) + 2) * (static_cast<std::size_t>(height) + 2) + 1;
}

/// Value of cell `at` of the padded table, whose ring is off the map, and so is what lies behind it.
PARLOC_HD std::int32_t table_value(const DistanceLikelihood& likelihood, const std::uint32_t* squared_cells,
                                   std::int32_t width, std::int32_t height, std::size_t at) {
  const std::size_t stride = static_cast<std::size_t>(width) + 2;
  const std::size_t i = at % stride, j = at / stride;
  const bool on_map = i >= 1 && i + 1 < stride && j >= 1 && j <= static_cast<std::size_t>(height);
  return likelihood.in_table(on_map ? squared_cells[(j - 1) * static_cast<std::size_t>(width) + (i - 1)]
                                    : kOffMap);
}

/// Of two values: their low halves count.
PARLOC_HD std::uint32_t packed_entry(std::int32_t own, std::int32_t above) {
  return (static_cast<std::uint32_t>(own) & 0xffffu) | static_cast<std::uint32_t>(above) << 16;
}

/// Entry of cell `at`. squared_cells: width x height, row-major, squared distance to the nearest wall
/// [cells^2].
PARLOC_HD std::uint32_t table_entry(const DistanceLikelihood& likelihood, const std::uint32_t* squared_cells,
                                    std::int32_t width, std::int32_t height, std::size_t at) {
  const std::size_t above = at + static_cast<std::size_t>(width) + 2;
  return packed_entry(table_value(likelihood, squared_cells, width, height, at),
                      table_value(likelihood, squared_cells, width, height, above));
}

}  // namespace parloc
