// The TUM reader on any bytes: an error, or poses that are all usable; and the metrics on them stay defined.
#include <cmath>

#include "common/eval/metrics.h"
#include "common/io/trajectory.h"
#include "tests/fuzz/one_line.h"

using parloc::fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const parloc::Trajectory track = parloc::tum_from_text(parloc::fuzz::text_of(data, size), "fuzz");
    require(!track.empty() && track.size() <= size);
    for (const auto& [stamp_s, pose] : track) {
      require(std::isfinite(stamp_s) && std::isfinite(pose.x_m) && std::isfinite(pose.y_m));
      require(pose.theta_rad >= -3.1415926535897932 && pose.theta_rad < 3.1415926535897932);
    }
    const parloc::TrackErrors errors = parloc::compare_tracks(track, track);
    require(errors.compared == track.size() && errors.without_truth == 0);
    require(std::isfinite(errors.position_rmse_m) && std::isfinite(errors.heading_max_rad));
  } catch (const parloc::Error&) {
  }
  return 0;
}
