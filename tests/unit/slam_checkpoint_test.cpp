// A run that was broken off and went on from a checkpoint ends with the bits of one that was not; and what is
// no checkpoint is told in one line.
#include <gtest/gtest.h>

#include <cstring>

#include "common/file/bytes.h"
#include "common/slam/checkpoint_values.h"
#include "common/slam/grid_slam.h"
#include "common/slam/grid_slam_config.h"
#include "common/slam/slam_settings.h"
#include "tests/system/program_runner.h"
#include "tests/unit/simulated.h"
#include "tests/unit/small_drive.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

/// 60 scans of two LiDARs in turn that take their time; the first three see nothing.
const std::vector<LogRecord>& drive() {
  static const std::vector<LogRecord> records = [] {
    std::vector<LogRecord> out = test::small_drive(test::small_room(), 60).scans;
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].scan.sensor = k % 2 == 0 ? "front" : "rear";
      out[k].scan.scan_time_s = 0.08;
      if (k < 3) out[k].scan.ranges_m.assign(out[k].scan.ranges_m.size(), 0.0f);
    }
    return out;
  }();
  return records;
}

GridSlamConfig config(int threads = 1) {
  GridSlamConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = threads;
  c.slam.particles = 6;
  c.scan.max_beams = 50;
  c.update_min_d = 0.12;
  c.slam.beta_weight = 0.5;  // so that it resamples
  c.motion.alpha3 = 0.4;
  c.lidars = {{.name = "rear", .yaw = 0.1}};
  return c;
}

/// The scans from `begin` to `end`; how many counted.
std::size_t run(GridSlam& slam, std::size_t begin, std::size_t end) {
  std::size_t counted = 0;
  for (std::size_t k = begin; k < end; ++k) {
    const LogRecord& record = drive()[k];
    slam.add_odometry(record.stamp_s - 0.03, record.odometry);
    counted += slam.step(record.odometry, record.scan) ? 1 : 0;
  }
  return counted;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

void expect_same(const GridSlam& a, const GridSlam& b) {
  EXPECT_EQ(a.digest(), b.digest());
  EXPECT_TRUE(same_bytes(a.trajectory(), b.trajectory()));
  EXPECT_TRUE(same_bytes(a.map().cells, b.map().cells));
  EXPECT_EQ(a.distinct_ancestors(), b.distinct_ancestors());
  ASSERT_EQ(a.records().size(), b.records().size());
  for (std::size_t k = 0; k < a.records().size(); ++k) {
    EXPECT_EQ(a.records()[k].n_eff, b.records()[k].n_eff);
    EXPECT_EQ(a.records()[k].resampled, b.records()[k].resampled);
    EXPECT_EQ(a.records()[k].tiles, b.records()[k].tiles);
  }
  EXPECT_EQ(a.memory().tile_bytes, b.memory().tile_bytes);
  EXPECT_EQ(a.memory().most_tile_bytes, b.memory().most_tile_bytes);
  EXPECT_EQ(a.memory().table_bytes, b.memory().table_bytes);
  ASSERT_EQ(a.lidars_used().size(), b.lidars_used().size());
  for (std::size_t k = 0; k < a.lidars_used().size(); ++k) {
    const LidarUse &x = a.lidars_used()[k], &y = b.lidars_used()[k];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.scans, y.scans);
    EXPECT_EQ(x.moving, y.moving);
    EXPECT_EQ(x.beams.used, y.beams.used);
  }
}

/// Broken off after `scans`, and then again after `again`.
void expect_no_trace(const GridSlam& whole, std::size_t scans, std::size_t again, int threads) {
  SCOPED_TRACE("broken off after " + std::to_string(scans) + " scans");
  const test::TempFile file("checkpoint");
  {
    GridSlam slam(whole.config());
    run(slam, 0, scans);
    slam.save(file.path(), "the caller's");
  }
  {
    SlamCheckpoint checkpoint(file.path());
    EXPECT_EQ(checkpoint.own, "the caller's");
    checkpoint.config.threads = threads;
    GridSlam slam(std::move(checkpoint));
    run(slam, scans, again);
    slam.save(file.path());
  }
  GridSlam slam{SlamCheckpoint(file.path())};
  run(slam, again, drive().size());
  expect_same(whole, slam);
}

TEST(SlamCheckpoint, ABreakLeavesNoTrace) {
  GridSlam whole(config());
  ASSERT_EQ(run(whole, 0, 3), 0u);  // before the first that counts
  ASSERT_EQ(run(whole, 3, 4), 1u);
  ASSERT_EQ(run(whole, 4, 5), 0u);  // between two that count
  run(whole, 5, drive().size());
  const auto& records = whole.records();
  ASSERT_GT(std::count_if(records.begin(), records.end(), [](const SlamRecord& r) { return r.resampled; }),
            2);
  ASSERT_LT(records.size(), drive().size() / 2);
  ASSERT_EQ(whole.lidars_used().size(), 2u);
  ASSERT_GT(whole.lidars_used()[1].moving, 5u);
  for (const std::size_t scans : {0, 1, 3, 4, 5, 6, 17, 30, 31, 32, 33, 34, 47, 59, 60})
    expect_no_trace(whole, scans, std::min<std::size_t>(scans + 9, 60), scans % 3 == 0 ? 1 : 3);
}

TEST(SlamCheckpoint, NorDoesOneOfOdometryFromScans) {
  GridSlamConfig c = config();
  c.slam.odometry = SlamOdometry::scans;
  GridSlam whole(c);
  run(whole, 0, drive().size());
  ASSERT_GT(whole.records().size(), 5u);
  for (const std::size_t scans : {2, 18, 58})
    expect_no_trace(whole, scans, std::min<std::size_t>(scans + 9, 60), 2);
}

TEST(SlamCheckpoint, NorDoesOneOfOdometryOutOfScale) {
  GridSlamConfig c = config();
  GridSlam plain(c);
  c.motion.odometry_scale_drive = 1.05, c.motion.odometry_scale_turn = 0.97;
  GridSlam whole(c);
  run(plain, 0, drive().size());
  run(whole, 0, drive().size());
  EXPECT_NE(plain.digest(), whole.digest());
  for (const std::size_t scans : {2, 18, 58})
    expect_no_trace(whole, scans, std::min<std::size_t>(scans + 9, 60), 2);
}

TEST(SlamCheckpoint, NorDoesOneBeforeAScanThatComesTwice) {
  GridSlamConfig c = config();
  c.scan.check_stamps = true;
  GridSlam whole(c);
  run(whole, 0, 10);
  const test::TempFile file("checkpoint");
  whole.save(file.path());
  GridSlam slam{SlamCheckpoint(file.path())};
  Pose far = drive().at(9).odometry;
  far.x_m += 1.0;  // would count
  EXPECT_FALSE(slam.step(far, drive().at(9).scan));
  EXPECT_FALSE(whole.step(far, drive().at(9).scan));
  expect_same(whole, slam);
}

TEST(SlamCheckpoint, SavingChangesNothing) {
  const test::TempFile file("checkpoint");
  GridSlam whole(config()), watched(config());
  run(whole, 0, drive().size());
  for (std::size_t k = 0; k < drive().size(); ++k) {
    run(watched, k, k + 1);
    watched.save(file.path());
  }
  expect_same(whole, watched);
}

class SlamCheckpointFile : public testing::Test {
 protected:
  SlamCheckpointFile() : file_("checkpoint") {
    GridSlam slam(config());
    run(slam, 0, 20);
    slam.save(file_.path());
    bytes_ = test::content_of(file_.path());
  }
  /// Of a file with this content.
  static std::string words(const std::string& bytes) {
    const std::string said = error_of([&] { GridSlam slam{SlamCheckpoint(bytes, "c")}; }, ErrorKind::input);
    EXPECT_EQ(said.rfind("c: ", 0), 0u) << said;
    expect_none_of(said, {"\n"});
    return said;
  }
  test::TempFile file_;
  std::string bytes_;
};

TEST_F(SlamCheckpointFile, WhatIsNoCheckpointIsTold) {
  expect_parts(words(""), {"expected a checkpoint"});
  expect_parts(words("image: map.pgm\nresolution: 0.05\n"), {"expected a checkpoint"});
  for (const std::size_t size :
       {std::size_t{23}, std::size_t{30}, std::size_t{90}, std::size_t{5000}, bytes_.size() - 1})
    expect_parts(words(bytes_.substr(0, size)), {"cut short"});
  for (const std::size_t place : {40u, 4000u}) {
    std::string damaged = bytes_;
    damaged[place] ^= 1;
    expect_parts(words(damaged), {"checksum"});
  }
  std::string newer = bytes_;
  newer[23] = 9;
  expect_parts(words(newer), {"found 9: made by a newer parloc"});
  error_of([] { SlamCheckpoint("no/such/file"); }, ErrorKind::input);
  error_of([] { SlamCheckpoint("/"); }, ErrorKind::input);
}

// With a checksum that fits: what the checksum cannot catch must not be believed either.
TEST_F(SlamCheckpointFile, NoCountIsBelieved) {
  const std::string content = bytes_.substr(27, bytes_.size() - 27 - 64);
  const auto sealed = [&](const std::string& what) {
    std::string out;
    ByteWriter w([&](const void* data, std::size_t n) { out.append(static_cast<const char*>(data), n); });
    put_checkpoint_begin(w);
    w.put_bytes(what.data(), what.size());
    put_checkpoint_end(w);
    return out;
  };
  ASSERT_EQ(sealed(content), bytes_);
  GridSlamConfig saved = config();
  const std::size_t state =
      8 + settings_to_yaml(settings_of(saved)).size() + 8;  // behind settings and the caller's own
  std::uint32_t random = 1;
  for (int k = 0; k < 120; ++k) {
    std::string changed = content;
    random = random * 1664525u + 1013904223u;
    // Where the counts are: at the beginning, and behind the tiles.
    const std::size_t from_end = (random >> 8) % 12000;
    const std::size_t place = k % 2 == 0 ? state + (random >> 8) % 200 : content.size() - 1 - from_end;
    changed[place] = static_cast<char>(k % 3 == 0 ? 0xff : random >> 24);
    try {
      GridSlam slam{SlamCheckpoint(sealed(changed), "c")};
      run(slam, 20, 22);
      (void)slam.trajectory();
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input) << e.what();
    }
  }
  for (std::size_t size = 0; size < content.size(); size += 997) words(sealed(content.substr(0, size)));
  words(sealed(content + "x"));
}

TEST_F(SlamCheckpointFile, GoesOnWithItsOwnSettingsOnly) {
  SlamCheckpoint other(file_.path());
  other.config.slam.usable_range = 7.0;
  expect_parts(error_of([&] { GridSlam slam(std::move(other)); }, ErrorKind::config),
               {"slam.usable_range is 30 there and 7 here"});
}

TEST(ConfigDifference, NamesTheFirstSettingThatDiffers) {
  GridSlamConfig a = config(), b = a;
  b.threads = 5, b.device = 3, b.backend = BackendChoice::cuda;
  EXPECT_EQ(config_difference(a, b), "");
  b.seed = 9;
  EXPECT_EQ(config_difference(a, b), "seed is 1 there and 9 here");
  b = a;
  b.slam.proposal = SlamProposal::gaussian;
  EXPECT_EQ(config_difference(a, b), "slam.proposal is scan_match there and gaussian here");
  b = a;
  b.lidars[0].x = 0.5;
  EXPECT_EQ(config_difference(a, b), "lidars.rear.x is not set there and 0.5 here");
  EXPECT_EQ(config_difference(b, a), "lidars.rear.x is 0.5 there and not set here");
}

}  // namespace
}  // namespace parloc
