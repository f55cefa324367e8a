// Every particle into its bin, with its weight. Once a filter has converged, a million particles are in a few
// bins: so a block first adds up its own in shared memory, bin by bin, and enters each of them once.
#pragma once

#include "common/filter/bins.h"
#include "common/filter/stages.h"
#include "cuda/launch.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

struct FillBins {
  static constexpr unsigned kRoom = kThreads;  // bins of a block; one thread enters each
  static constexpr unsigned kTries = 8;        // a particle that finds no room enters alone
  static constexpr int kPartBits = 21;         // weights are at most 2^40, so two parts are enough, ...
  static constexpr std::uint32_t kAlone = kRoom;
  static constexpr std::size_t kMostEach = 4;                                  // particles of a thread
  static_assert(kThreads * kMostEach < (std::size_t{1} << (32 - kPartBits)));  // ... and their sums fit
  struct Shared {
    std::uint64_t key[kRoom];
    std::uint32_t low[kRoom], high[kRoom];      // of the weight
    std::uint32_t slot[kRoom];                  // in the table of all
    std::uint16_t place[kThreads * kMostEach];  // of each particle, in these
  };
  static constexpr int kPhases = 4;
  BinTable t;
  Particles p;
  const std::uint64_t* weight;
  std::uint32_t each;  // particles of a thread, 1 to kMostEach

  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    const unsigned mine = me.thread;
    if (phase == 0) s.key[mine] = kNoBin, s.low[mine] = s.high[mine] = 0;
    if (phase == 1) add_up(me, s);
    if (phase == 2 && s.key[mine] != kNoBin) {
      s.slot[mine] = bin_find_or_make(t, s.key[mine]);
      atomic_add(&t.weight[s.slot[mine]],
                 (static_cast<std::uint64_t>(s.high[mine]) << kPartBits) + s.low[mine]);
    }
    if (phase == 3) note_slots(me, s);
  }

 private:
  PARLOC_HD std::size_t particle(const Thread& me, std::size_t k) const {
    return (std::size_t{me.block} * each + k) * kThreads + me.thread;
  }
  PARLOC_HD void add_up(const Thread& me, Shared& s) const {
    for (std::size_t k = 0; k < each; ++k) {
      const std::size_t i = particle(me, k);
      if (i >= p.count()) return;
      const std::uint64_t key = bin_key_of(p.x[i], p.y[i], p.theta[i]);
      const std::uint32_t place = place_of(key, s);
      s.place[k * kThreads + me.thread] = static_cast<std::uint16_t>(place);
      if (place == kAlone) {
        t.slot_of[i] = bin_find_or_make(t, key);
        atomic_add(&t.weight[t.slot_of[i]], weight[i]);
      } else {
        atomic_add(&s.low[place], static_cast<std::uint32_t>(weight[i]) & ((1u << kPartBits) - 1));
        atomic_add(&s.high[place], static_cast<std::uint32_t>(weight[i] >> kPartBits));
      }
    }
  }
  PARLOC_HD static std::uint32_t place_of(std::uint64_t key, Shared& s) {
    std::uint32_t place = bin_hash(key, kRoom);
    for (unsigned n = 0; n < kTries; ++n, place = bin_after(place, kRoom)) {
      std::uint64_t found = atomic_read(&s.key[place]);
      if (found == kNoBin) found = atomic_swap_if(&s.key[place], kNoBin, key);
      if (found == kNoBin || found == key) return place;
    }
    return kAlone;
  }
  PARLOC_HD void note_slots(const Thread& me, const Shared& s) const {
    for (std::size_t k = 0; k < each; ++k) {
      const std::size_t i = particle(me, k);
      if (i >= p.count()) return;
      const std::uint32_t place = s.place[k * kThreads + me.thread];
      if (place != kAlone) t.slot_of[i] = s.slot[place];
    }
  }
};

/// Few particles are spread over all of the device.
inline void fill_bins(const BinTable& t, const Particles& p, const std::uint64_t* weight, Stream stream) {
  constexpr std::size_t kBlocksThatFillADevice = 128;
  const std::size_t blocks = (p.capacity + kThreads - 1) / kThreads;
  const std::size_t each = blocks > kBlocksThatFillADevice ? FillBins::kMostEach : 1;
  launch_step(FillBins{t, p, weight, static_cast<std::uint32_t>(each)},
              static_cast<unsigned>((blocks + each - 1) / each), stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
