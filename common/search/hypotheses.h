// From the champions of a search to a few separated hypotheses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "common/search/lattice.h"

namespace parloc {

/// A pose of the lattice.
struct LatticePose {
  std::int32_t i = 0, j = 0, k = 0;  ///< Cell and heading.
  std::uint32_t score = 0;
};

/// How far apart two hypotheses are at least, in place or in heading.
struct Separation {
  double distance_m = 0.0;
  double angle_rad = 0.0;
};
bool separated(const Pose& a, const Pose& b, const Separation& s);

/// Poses of the lattice, chosen from their keys greedily by score, the first on the lattice among equals: a
/// pose too close to one that was taken is left out. In slices; everything keeps its capacity.
class SeparatePoses {
 public:
  std::vector<std::uint64_t> keys;  ///< To be filled after `begin`; in any order.

  /// At most `most` of a grid of width x height cells. Forgets the keys.
  void begin(const SearchGrid& grid, std::int32_t headings, double cell_m, const Separation& separation,
             std::size_t most);
  /// Does about so much work [search_work.h], but something; returns how much it was.
  std::int64_t advance(std::int64_t work);
  bool done() const { return done_; }
  const std::vector<LatticePose>& taken() const { return taken_; }

 private:
  std::int64_t take_best();
  LatticePose pose_of_key(std::uint64_t key) const;

  std::int32_t width_ = 0, height_ = 0, headings_ = 0;
  double cell_m_ = 0.0;
  Separation separation_;
  std::size_t most_ = 0, in_order_ = 0;  // in_order_: keys that are a heap
  bool done_ = true;
  std::vector<LatticePose> taken_;
  std::vector<Pose> poses_;  // of those
};

/// Grid frame.
Pose pose_of(const LatticePose& p, std::int32_t headings, double cell_m);

}  // namespace parloc
