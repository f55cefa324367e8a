// The recorded log of the golden digests: 37 scans, with a map of another day. Both are decimal text and grey
// values, so that every machine starts from the same bits (maps/logs/README.md has the start pose).
#pragma once

#include <gtest/gtest.h>

#include "common/config/config.h"
#include "common/eval/metrics.h"
#include "common/io/log.h"
#include "common/map/map_reader.h"

namespace parloc::test {

inline const std::string kMaps = std::string(PARLOC_SOURCE_DIR) + "/maps/";
constexpr std::size_t kCorridorScans = 37;
constexpr Pose kCorridorStart{3.453, -10.171, -0.485};
constexpr double kCorridorSigma_m = 0.2, kCorridorSigma_rad = 0.1;

inline const GridMap& corridor() {
  static const GridMap map = read_map(kMaps + "malaga_corridor.yaml");
  return map;
}
inline std::unique_ptr<LogReader> corridor_log() {
  return open_carmen_log(kMaps + "logs/malaga_corridor.log.gz");
}

/// A digest is worth pinning only of a run that kept track; odometry alone ends 1.7 m off.
inline void expect_on_track(const Trajectory& track) {
  const TrackErrors errors = compare_tracks(track, read_tum(kMaps + "logs/malaga_corridor.tum"));
  EXPECT_LT(errors.position_max_m, 1.0);
}

/// Every setting is written out: a changed default must not change a golden digest.
constexpr MotionConfig kGoldenMotion{.form = MotionForm::seed,
                                     .alpha1 = 0.2,
                                     .alpha2 = 0.1,
                                     .alpha3 = 0.2,
                                     .alpha4 = 0.1,
                                     .alpha5 = 0.2,
                                     .sigma_rot_min_rad = 0.001,
                                     .sigma_trans_min_m = 0.002,
                                     .sigma_rot_per_s = 0.0,
                                     .sigma_trans_per_s = 0.0,
                                     .slip_share = 0.0,
                                     .slip_sigma_m = 0.3,
                                     .slip_sigma_rad = 0.2,
                                     .min_translation_m = 0.01,
                                     .symmetric = true,
                                     .max_speed_mps = 10.0,
                                     .max_acceleration_mps2 = 10.0,
                                     .max_turn_rate_rad_s = 12.0,
                                     .max_jump_m = 1.0,
                                     .odometry_delay_s = 0.0};

}  // namespace parloc::test
