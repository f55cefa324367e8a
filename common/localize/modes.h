// The places that a particle set stands for: its clusters, where the estimate knows the heaviest one only.
#pragma once

#include <cstddef>
#include <vector>

#include "common/filter/particle_filter.h"

namespace parloc {

/// A connected cluster of 0.5 m x 0.5 m x 10 degree bins.
struct Mode {
  Pose pose;            ///< Its weighted mean.
  double weight = 0.0;  ///< Share of the total, 0 to 1.
};

/// The heaviest first, those below `least` left out. On the host: for when a filter has not made up its mind.
std::vector<Mode> find_modes(const std::vector<Particle>& particles, double least);

}  // namespace parloc
