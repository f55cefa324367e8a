// A proposal that the scan has improved: some particles are put where the scan says that the robot may be,
// with the weights that make this an honest sample of where the motion says that it may be (importance
// sampling; as Grisetti et al. 2007 do for mapping, eq. 9 to 16).
#pragma once

#include <cstdint>

#include "common/filter/filter_backend.h"
#include "common/filter/pose/pose_guess.h"
#include "common/map/grid_map.h"

namespace parloc {

/// Draws `share` of the particles, evenly by slot, about `guess` (map frame) instead. The log-weight of each
/// is that of the slip's density over the guess's, and of the odds; the others keep theirs. All in one frame
/// of time: both poses are before the motion of the step that comes. `step` tells draws of one run apart.
void propose_particles(ParticleSet& set, const GridMap& map, const PoseGuess& guess, double share,
                       const SlipPrior& slip, std::uint32_t step, std::uint64_t seed);

}  // namespace parloc
