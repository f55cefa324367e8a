// The heaviest cluster of a particle set: occupied bins of 0.5 m x 0.5 m x 10 degrees (Fox 2003), joined
// where they touch (26 neighbours, heading cyclic). A hash table with integer weights and roots chosen by
// key: the result does not depend on the order in which threads insert or join.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/atomics.h"
#include "common/math/host_device.h"
#include "common/math/portable.h"

namespace parloc {

constexpr std::uint64_t kNoBin = ~std::uint64_t{0};
constexpr std::int32_t kHeadingBins = 36;
constexpr float kBinSize_m = 0.5f;
constexpr std::uint32_t kBinNeighbours = 27;  // 3 x 3 x 3, itself among them

/// Open addressing; `capacity` is bin_capacity(particles), so it never fills.
/// Empty slots have kNoBin, no weight and themselves as parent; a step leaves the table empty by clearing
/// what it used.
struct BinTable {
  std::uint64_t* key = nullptr;      ///< [capacity] kNoBin where empty
  std::uint64_t* weight = nullptr;   ///< [capacity] of the bin; after the sums, at a root, of its cluster
  std::uint32_t* parent = nullptr;   ///< [capacity] union-find; the root has the smallest key of its cluster
  std::uint32_t* slot_of = nullptr;  ///< [N] where a particle's bin is
  std::uint32_t* used = nullptr;     ///< [N] Slots in use, in any order.
  std::uint64_t* used_count = nullptr;  ///< [1] How many those are.
  std::uint32_t capacity = 0;
};

PARLOC_HD std::uint64_t bin_key(std::int32_t bx, std::int32_t by, std::int32_t bt) {
  const std::uint64_t ux = static_cast<std::uint32_t>(bx + (1 << 23)) & 0xffffffu;
  const std::uint64_t uy = static_cast<std::uint32_t>(by + (1 << 23)) & 0xffffffu;
  return (ux << 30) | (uy << 6) | static_cast<std::uint32_t>(bt);
}

PARLOC_HD std::int32_t bin_index(float metres) {
  return static_cast<std::int32_t>(floor_of(min_of(max_of(metres * (1.0f / kBinSize_m), -4e6f), 4e6f)));
}

PARLOC_HD std::uint64_t bin_key_of(float x_m, float y_m, float theta_rad) {
  const std::int32_t t =
      static_cast<std::int32_t>(floor_of((theta_rad + 3.14159274f) * (kHeadingBins / 6.28318548f)));
  return bin_key(bin_index(x_m), bin_index(y_m), t < 0 ? 0 : (t >= kHeadingBins ? kHeadingBins - 1 : t));
}

/// A quarter more than the bins that there can be.
PARLOC_HD std::uint32_t bin_capacity(std::size_t particles) {
  return static_cast<std::uint32_t>(particles + particles / 4 + 4);
}

PARLOC_HD std::uint32_t bin_hash(std::uint64_t key, std::uint32_t capacity) {
  std::uint64_t h = key * 0x9E3779B97F4A7C15u;
  h ^= h >> 32;
  return static_cast<std::uint32_t>(((h & 0xffffffffu) * capacity) >> 32);
}

PARLOC_HD std::uint32_t bin_after(std::uint32_t slot, std::uint32_t capacity) {
  return slot + 1 < capacity ? slot + 1 : 0;
}

PARLOC_HD void bin_clear(const BinTable& t, std::uint32_t slot) {
  t.key[slot] = kNoBin;
  t.weight[slot] = 0;
  t.parent[slot] = slot;
}

/// The slot of the bin of `key`, which is made if there is none.
PARLOC_HD std::uint32_t bin_find_or_make(const BinTable& t, std::uint64_t key) {
  for (std::uint32_t slot = bin_hash(key, t.capacity);; slot = bin_after(slot, t.capacity)) {
    std::uint64_t found = atomic_read(&t.key[slot]);
    if (found == kNoBin) {
      found = atomic_swap_if(&t.key[slot], kNoBin, key);
      if (found == kNoBin) t.used[atomic_add(t.used_count, 1)] = slot;
    }
    if (found == kNoBin || found == key) return slot;
  }
}

/// Empties the table, on one thread.
PARLOC_HD void bin_clear_used(const BinTable& t) {
  for (std::uint64_t k = 0; k < *t.used_count; ++k) bin_clear(t, t.used[k]);
  *t.used_count = 0;
}

/// The slot of `key`, or capacity if there is no such bin.
PARLOC_HD std::uint32_t bin_find(const BinTable& t, std::uint64_t key) {
  for (std::uint32_t slot = bin_hash(key, t.capacity);; slot = bin_after(slot, t.capacity)) {
    if (t.key[slot] == key) return slot;
    if (t.key[slot] == kNoBin) return t.capacity;
  }
}

PARLOC_HD std::uint32_t bin_root(const BinTable& t, std::uint32_t slot) {
  for (;;) {
    const std::uint32_t up = atomic_read(&t.parent[slot]);
    if (up == slot) return slot;
    slot = up;
  }
}

/// The same once all are joined: nobody writes any more, so caches may serve it.
PARLOC_HD std::uint32_t bin_settled_root(const BinTable& t, std::uint32_t slot) {
  while (t.parent[slot] != slot) slot = t.parent[slot];
  return slot;
}

/// Joins two clusters under the root with the smaller key.
PARLOC_HD void bin_join(const BinTable& t, std::uint32_t a, std::uint32_t b) {
  for (;;) {
    a = bin_root(t, a);
    b = bin_root(t, b);
    if (a == b) return;
    const std::uint32_t low = t.key[a] < t.key[b] ? a : b;
    const std::uint32_t high = low == a ? b : a;
    if (atomic_swap_if(&t.parent[high], high, low) == high) return;
  }
}

/// Joins the bin in `slot` with one of its neighbours, 0 to kBinNeighbours - 1, if there is one with a larger
/// key (each pair is met once).
PARLOC_HD void bin_join_neighbour(const BinTable& t, std::uint32_t slot, std::uint32_t neighbour) {
  const std::uint64_t key = t.key[slot];
  const std::int32_t bx = static_cast<std::int32_t>((key >> 30) & 0xffffffu) - (1 << 23);
  const std::int32_t by = static_cast<std::int32_t>((key >> 6) & 0xffffffu) - (1 << 23);
  const std::int32_t bt = static_cast<std::int32_t>(key & 63u);
  const std::int32_t n = static_cast<std::int32_t>(neighbour);
  const std::int32_t dx = n / 9 - 1, dy = n / 3 % 3 - 1, dt = n % 3 - 1;
  const std::int32_t nt = (bt + dt + kHeadingBins) % kHeadingBins;
  const std::uint64_t other = bin_key(bx + dx, by + dy, nt);
  if (other <= key) return;
  const std::uint32_t found = bin_find(t, other);
  if (found != t.capacity) bin_join(t, slot, found);
}

}  // namespace parloc
