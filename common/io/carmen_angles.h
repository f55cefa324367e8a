// Where the beams of FLASER and RLASER lines look, which say no angles, and the step of ROBOTLASER lines,
// which round it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace parloc {

/// An angle that a log states, and the most by which its rounding may have changed it.
struct StatedAngle {
  double rad = 0.0;
  double rounding_rad = 0.0;
};

/// Half a unit of a number's last written place: 0.00005 of "0.0044", 0.5 of "180".
double half_last_place(std::string_view number);

/// Beam i looks at min_rad + i * step_rad, counter-clockwise, 0 ahead.
struct BeamAngles {
  double min_rad = 0.0;
  double step_rad = 0.0;
  std::string doubt{};  ///< Why they may be wrong, in a few words; empty if there is nothing against them.
};

/// The step of `beams` beams that a log gives as `step` with a field of view `fov`, which is finer than the
/// step times many beams: fov / (beams - 1) or fov / beams where it rounds to `step`, else `step` itself.
/// Logs count the field of view either way. Deterministic.
double beam_step_rad(const StatedAngle& fov, const StatedAngle& step, std::size_t beams);

/// The angles of a scan that has none. First what the log states (PARAM lines; either may be missing), then
/// what is known of that number of beams (GMapping's and CARMEN's tables: Hokuyo's 270 degrees and steps of
/// 360 / 1024 degrees), then the half circle: an even count leaves its last end out (180 beams: 1 degree,
/// 360: 0.5), an odd count has both (181, 361); one beam looks ahead. Deterministic.
BeamAngles angles_of_count(std::size_t beams, const std::optional<StatedAngle>& fov,
                           const std::optional<StatedAngle>& step);

}  // namespace parloc
