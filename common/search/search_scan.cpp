#include "common/search/search_scan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/portable64.h"

namespace parloc {
namespace {

/// No end point is farther than this [cells]: off every map, and nothing overflows.
constexpr double kFarthest = 1e6;

void choose_hits(const BeamTable& table, double map_resolution_m, std::size_t most, SearchScan& scan) {
  const std::size_t count = std::min(table.hits, most);
  scan.beams = static_cast<std::int32_t>(count);
  scan.end_x_m.clear();
  scan.end_y_m.clear();
  std::size_t stride = count * 618 / 1000 + 1;
  while (count > 0 && std::gcd(stride, count) != 1) ++stride;
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t m = (n * stride % count) * table.hits / count;
    scan.end_x_m.push_back(static_cast<float>(table.end_x[m] * map_resolution_m));
    scan.end_y_m.push_back(static_cast<float>(table.end_y[m] * map_resolution_m));
  }
}

std::int32_t headings_for(const SearchScan& scan, double cell_m, const SearchConfig& config) {
  double farthest_m = 0.0;
  for (std::size_t b = 0; b < scan.end_x_m.size(); ++b) {
    const double x = scan.end_x_m[b], y = scan.end_y_m[b];
    farthest_m = std::max(farthest_m, std::sqrt(x * x + y * y));
  }
  const double wanted = 2.0 * kPi * farthest_m / (config.heading_cells * cell_m);
  const double rounds = std::ceil(std::clamp(wanted, 72.0, 1e6) / kDiveStep);
  return kDiveStep * std::min(static_cast<std::int32_t>(rounds), config.max_headings / kDiveStep);
}

/// To the nearest cell: a floor that is no call.
std::int32_t offset_of(double distance_cells) {
  const double moved = 0.5 + std::clamp(distance_cells, -kFarthest, kFarthest);
  const auto cut = static_cast<std::int32_t>(moved);
  return moved < cut ? cut - 1 : cut;
}

}  // namespace

double SearchScan::heading_rad(std::int32_t k) const {
  return wrap64(2.0 * kPi * k / headings);
}

void choose_search_beams(const BeamTable& table, double map_resolution_m, double cell_m,
                         const SearchConfig& config, SearchScan& scan) {
  choose_hits(table, map_resolution_m, static_cast<std::size_t>(config.beams), scan);
  scan.headings = headings_for(scan, cell_m, config);
  const std::size_t offsets = static_cast<std::size_t>(scan.headings) * scan.end_x_m.size();
  if (scan.offsets.size() < offsets) scan.offsets.resize(offsets);
}

void turn_search_scan(SearchScan& scan, double cell_m, std::int32_t k) {
  const std::size_t beams = scan.end_x_m.size();
  const double per_cell = 1.0 / cell_m;
  const SinCos64 r = portable_sincos64(scan.heading_rad(k));
  Offset* out = scan.offsets.data() + static_cast<std::size_t>(k) * beams;
  for (std::size_t b = 0; b < beams; ++b) {
    const double x = scan.end_x_m[b] * per_cell, y = scan.end_y_m[b] * per_cell;
    out[b] = {offset_of(r.cos * x - r.sin * y), offset_of(r.sin * x + r.cos * y)};
  }
}

void make_search_scan(const BeamTable& table, double map_resolution_m, double cell_m,
                      const SearchConfig& config, SearchScan& scan) {
  choose_search_beams(table, map_resolution_m, cell_m, config, scan);
  for (std::int32_t k = 0; k < scan.headings; ++k) turn_search_scan(scan, cell_m, k);
}

}  // namespace parloc
