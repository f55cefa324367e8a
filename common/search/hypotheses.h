// From the champions of a search to a few separated hypotheses.
#pragma once

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

/// Greedily by score, the first on the lattice among equals: a pose too close to one that was taken is left
/// out. At most `most`. Sorts `keys`.
std::vector<LatticePose> separate(std::vector<std::uint64_t>& keys, std::int32_t width, std::int32_t height,
                                  std::int32_t headings, double cell_m, const Separation& separation,
                                  std::size_t most);

/// Grid frame.
Pose pose_of(const LatticePose& p, std::int32_t headings, double cell_m);

}  // namespace parloc
