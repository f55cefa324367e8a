// `parloc slam` broken off while it closes loops: the particle's map, and a checkpoint that ends where a run
// without a break does.
#include "tools/slam/map_log.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/unit/small_drive.h"
#include "tests/unit/temp_file.h"
#include "tools/slam/results.h"

namespace parloc::tools::slam {
namespace {

MapRequest request_of(const std::string& log, const std::string& checkpoint) {
  MapRequest request;
  request.log_name = log;
  request.checkpoint = checkpoint;
  request.config.backend = BackendChoice::cpu;
  request.config.slam.particles = 3;
  request.config.slam_update_min_d = 0.1;
  return request;
}

TEST(MapLog, ABreakWhileLoopsAreClosedLeavesThemOpen) {
  const test::TempFile log("drive.log", carmen_log_of(test::small_drive(test::small_room(), 60)));
  const test::TempFile checkpoint("checkpoint");
  MapRequest request = request_of(log.path(), checkpoint.path());
  double done = 0.0;
  request.closing = [&](double fraction) {
    EXPECT_GE(fraction, done);
    done = fraction;
  };
  const Mapping whole = map_log(*open_carmen_log(log.path()), request);
  ASSERT_FALSE(whole.interrupted);
  EXPECT_EQ(done, 1.0);
  ASSERT_TRUE(whole.loops.has_value());
  ASSERT_TRUE(whole.resident_bytes.has_value());
  EXPECT_GT(*whole.resident_bytes, whole.memory.most_tile_bytes);

  done = 0.0;
  request.stop = [&] { return done > 0.5; };
  const Mapping broken = map_log(*open_carmen_log(log.path()), request);
  EXPECT_TRUE(broken.interrupted);
  EXPECT_LT(done, 1.0);
  EXPECT_EQ(broken.scans, whole.scans);
  EXPECT_EQ(broken.trajectory.size(), whole.trajectory.size());
  EXPECT_FALSE(broken.loops.has_value());
  ASSERT_TRUE(std::filesystem::exists(checkpoint.path()));

  SlamCheckpoint from(checkpoint.path());
  MapRequest again = request_of(log.path(), {});
  again.resume = &from;
  const Mapping resumed = map_log(*open_carmen_log(log.path()), again);
  EXPECT_FALSE(resumed.interrupted);
  EXPECT_EQ(resumed.digest, whole.digest);
  EXPECT_EQ(resumed.resumed_at, whole.scans);
  EXPECT_EQ(resumed.growth.size(), whole.growth.size());
}

TEST(MapLog, AJumpOfTheOdometryAndStampsThatStandStillAreSaid) {
  test::SmallDrive drive = test::small_drive(test::small_room(), 30);
  for (int k = 15; k < 30; ++k) drive.scans[k].odometry.x_m += 5.0;
  const auto mapped = [&] {
    const test::TempFile log("drive.log", carmen_log_of(drive));
    SlamResults results;
    results.mapping = map_log(*open_carmen_log(log.path()), request_of(log.path(), {}));
    EXPECT_EQ(results.mapping.odometry_jumps, 1u);
    return summary_text(results);
  };
  EXPECT_NE(mapped().find("1 jumps of the odometry"), std::string::npos);
  for (LogRecord& record : drive.scans) record.stamp_s = record.scan.stamp_s = 0.0;
  const std::string still = mapped();
  EXPECT_NE(still.find("stamps stand still: 29 of 30 scans"), std::string::npos) << still;
  EXPECT_EQ(still.find("stamp of the"), still.rfind("stamp of the")) << still;  // once
}

}  // namespace
}  // namespace parloc::tools::slam
