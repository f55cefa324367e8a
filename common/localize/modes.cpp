#include "common/localize/modes.h"

#include <algorithm>
#include <cstdint>
#include <map>

#include "common/filter/bins.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

struct Sums {
  double weight = 0, x = 0, y = 0, cos = 0, sin = 0;
  bool taken = false;
};
using Bins = std::map<std::uint64_t, Sums>;

/// Calls visit(key) for the bins around a bin, heading cyclic.
template <class Visit>
void around(std::uint64_t key, const Visit& visit) {
  const std::int32_t bx = static_cast<std::int32_t>((key >> 30) & 0xffffffu) - (1 << 23);
  const std::int32_t by = static_cast<std::int32_t>((key >> 6) & 0xffffffu) - (1 << 23);
  const std::int32_t bt = static_cast<std::int32_t>(key & 63u);
  for (std::int32_t dx = -1; dx <= 1; ++dx)
    for (std::int32_t dy = -1; dy <= 1; ++dy)
      for (std::int32_t dt = -1; dt <= 1; ++dt)
        visit(bin_key(bx + dx, by + dy, (bt + dt + kHeadingBins) % kHeadingBins));
}

/// The sums over all bins that hang together with `first`.
Sums collect(Bins& bins, Bins::iterator first) {
  Sums sum;
  std::vector<Bins::iterator> open{first};
  first->second.taken = true;
  while (!open.empty()) {
    const Bins::iterator at = open.back();
    open.pop_back();
    const Sums& s = at->second;
    sum.weight += s.weight, sum.x += s.x, sum.y += s.y, sum.cos += s.cos, sum.sin += s.sin;
    around(at->first, [&](std::uint64_t key) {
      const auto next = bins.find(key);
      if (next == bins.end() || next->second.taken) return;
      next->second.taken = true;
      open.push_back(next);
    });
  }
  return sum;
}

}  // namespace

std::vector<Mode> find_modes(const std::vector<Particle>& particles, double least) {
  Bins bins;
  double total = 0.0;
  for (const Particle& p : particles) {
    if (!(p.weight > 0.0f)) continue;
    const SinCos64 h = portable_sincos64(p.theta_rad);
    const double w = p.weight;
    Sums& s = bins[bin_key_of(p.x_m, p.y_m, p.theta_rad)];
    s.weight += w, s.x += w * p.x_m, s.y += w * p.y_m, s.cos += w * h.cos, s.sin += w * h.sin;
    total += w;
  }
  std::vector<Mode> modes;
  for (auto bin = bins.begin(); bin != bins.end(); ++bin) {
    if (bin->second.taken) continue;
    const Sums s = collect(bins, bin);
    if (s.weight < least * total) continue;
    modes.push_back({{s.x / s.weight, s.y / s.weight, portable_atan2_64(s.sin, s.cos)}, s.weight / total});
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const Mode& a, const Mode& b) { return a.weight > b.weight; });
  return modes;
}

}  // namespace parloc
