#include "tools/program/load_map.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "common/file/input_file.h"
#include "common/map/map_reader.h"
#include "common/map/segment_map.h"

namespace parloc::tools {

LoadedMap load_map(const std::string& path, std::optional<double> resolution_m) {
  const std::string text = read_input_file(path, path, kLongestSegmentFile + 1);
  if (!is_segment_text(text, path)) return {read_map(path), {}};
  SegmentMap segments = segment_map_from_text(text, path);
  if (resolution_m) segments.resolution_m = *resolution_m;
  PlacedSegments placed = place_segments(segments, path);
  return {std::move(placed.map),
          SegmentFacts{segments.name, placed.zero_length, placed.duplicates, placed.enclosed}};
}

double total_length_m(const GridMap& map) {
  double sum_m = 0.0;
  for (const GridWall& w : map.walls) sum_m += std::hypot(double{w.bx} - w.ax, double{w.by} - w.ay);
  return sum_m;
}

std::string left_out(const SegmentFacts& facts) {
  if (facts.zero_length + facts.duplicates == 0) return {};
  return fmt::format("{} of zero length, {} duplicate{}", facts.zero_length, facts.duplicates,
                     facts.duplicates == 1 ? "" : "s");
}

}  // namespace parloc::tools
