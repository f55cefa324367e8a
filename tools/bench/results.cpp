#include "tools/bench/results.h"

#include <fmt/format.h>

#include <algorithm>

namespace parloc::tools::bench {

std::size_t Results::index_of(const Variant& variant) {
  const auto found = std::find(variants.begin(), variants.end(), variant);
  const auto index = static_cast<std::size_t>(found - variants.begin());
  if (found == variants.end()) {
    variants.push_back(variant);
    backends.emplace_back();
  }
  return index;
}

const Row* Results::find(Sweep sweep, const Place& place, std::size_t variant, std::int64_t particles,
                         int beams) const {
  for (const Row& row : rows) {
    if (row.sweep == sweep && row.place == place && row.variant == variant && row.particles == particles &&
        row.beams == beams)
      return &row;
  }
  return nullptr;
}

std::vector<Place> Results::places() const {
  std::vector<Place> found;
  const auto add = [&](const Place& place) {
    if (std::find(found.begin(), found.end(), place) == found.end()) found.push_back(place);
  };
  for (const Row& row : rows) add(row.place);
  for (const Largest& l : largest) add(l.place);
  return found;
}

std::vector<std::size_t> Results::variants_of(Sweep sweep, const Place& place) const {
  std::vector<std::size_t> found;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const bool any = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.variant == v && row.sweep == sweep && row.place == place;
    });
    if (any) found.push_back(v);
  }
  return found;
}

std::string name_of(const Place& place, std::int64_t particles, int beams) {
  return fmt::format("{}, {}, {} x {}", place.scene, place.cloud, particles, beams);
}

std::vector<std::string> skipped_lines(const std::vector<Skipped>& skipped) {
  struct Group {
    std::string why, first;
    std::size_t count;
  };
  std::vector<Group> groups;
  for (const Skipped& s : skipped) {
    const auto same =
        std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.why == s.why; });
    if (same != groups.end()) {
      ++same->count;
    } else {
      groups.push_back({s.why, s.what, 1});
    }
  }
  std::vector<std::string> lines;
  for (const Group& g : groups) {
    const std::string more = g.count > 1 ? fmt::format(" and {} more", g.count - 1) : "";
    lines.push_back(fmt::format("skipped {}{}: {}", g.first, more, g.why));
  }
  return lines;
}

}  // namespace parloc::tools::bench
