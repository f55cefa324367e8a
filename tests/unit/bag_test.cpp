// Bags in every container: the same messages come out of all of them, and damage costs no more than what is
// damaged. The files are those of tests/bags/make_corpus.py, written by rosbags and mcap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/io/bag_log.h"
#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::TempFile;

const std::string kCorpus = "tests/fuzz/corpus/";

std::vector<std::string> all_bags() {
  std::vector<std::string> bags;
  for (const char* folder : {"mcap", "ros1_bag", "sqlite_bag"})
    for (const auto& entry : fs::directory_iterator(kCorpus + folder)) bags.push_back(entry.path().string());
  std::sort(bags.begin(), bags.end());
  return bags;
}

struct Drive {
  std::vector<LogRecord> scans;
  LogWarnings warnings;
};

Drive read_drive(const std::string& path, const LogChoice& choice = {}) {
  Drive drive;
  const auto log = open_bag_log(path, choice);
  for (LogRecord record; log->next(record);)
    if (record.kind == RecordKind::scan) drive.scans.push_back(record);
  drive.warnings = log->warnings();
  return drive;
}

/// So many scans, each as it was written.
void expect_the_drive(const Drive& drive, std::size_t scans) {
  ASSERT_EQ(drive.scans.size(), scans);
  for (const LogRecord& record : drive.scans) {
    const double k = (record.stamp_s - 1.7e9) / 0.25;
    ASSERT_TRUE(k == 0.0 || k == 1.0 || k == 2.0 || k == 3.0) << record.stamp_s;
    expect_near(record.odometry, {0.5 * k, -0.25 * k, 0.125 * k}, 1e-12, 1e-12);
    expect_equal(record.scan.T_base_sensor, {});
    EXPECT_EQ(record.scan.sensor, "scan");
    EXPECT_EQ(record.scan.angle_min_rad, -1.0);
    EXPECT_EQ(record.scan.angle_step_rad, 0.25);
    EXPECT_EQ(record.scan.range_max_m, 8.0);
    ASSERT_EQ(record.scan.ranges_m.size(), 8u);
    for (std::size_t beam = 0; beam < 7; ++beam)
      EXPECT_EQ(record.scan.ranges_m[beam],
                1.0f + 0.25f * static_cast<float>(beam) + 0.125f * static_cast<float>(k));
    EXPECT_TRUE(std::isinf(record.scan.ranges_m[7]));
  }
}

TEST(Bag, EveryContainerHoldsTheSameDrive) {
  const std::vector<std::string> bags = all_bags();
  ASSERT_EQ(bags.size(), 14u);
  for (const std::string& path : bags) {
    SCOPED_TRACE(path);
    const Drive drive = read_drive(path);
    expect_the_drive(drive, 4);
    const std::size_t faults = path.ends_with("ros1_bag/no_index.bag") ? 1 : 0;
    EXPECT_EQ(drive.warnings.broken_lines, faults);
  }
}

TEST(Bag, IsToldByItsContent) {
  for (const std::string& path : all_bags()) {
    const TempFile renamed("carmen.log", content_of(path));
    EXPECT_TRUE(is_bag(renamed.path())) << path;
    EXPECT_EQ(open_bag(renamed.path())->topics().size(), 3u) << path;
  }
  EXPECT_FALSE(is_bag("maps/office.yaml"));
  EXPECT_FALSE(is_bag("/no/such/bag.mcap"));
}

TEST(Bag, GivesMessagesInTheOrderOfTheirRecording) {
  for (const std::string& path : all_bags()) {
    const auto bag = open_bag(path);
    std::int64_t last_ns = 0;
    std::size_t count = 0;
    for (BagMessage message; bag->next(message); ++count) {
      EXPECT_GE(message.stamp_ns, last_ns) << path;
      last_ns = message.stamp_ns;
    }
    EXPECT_EQ(count, 9u) << path;
  }
}

TEST(Bag, GivesTheSelectedTopicsAloneAndAgain) {
  for (const std::string& path : all_bags()) {
    const auto bag = open_bag(path);
    std::vector<bool> scans;
    for (const BagTopic& topic : bag->topics()) scans.push_back(topic.type == "sensor_msgs/LaserScan");
    for (int pass = 0; pass < 2; ++pass) {
      bag->select(scans);
      std::size_t count = 0;
      for (BagMessage message; bag->next(message); ++count)
        EXPECT_EQ(bag->topics()[message.topic].name, "/scan") << path;
      EXPECT_EQ(count, 4u) << path;
    }
    for (std::size_t k = 0; k < bag->topics().size(); ++k) EXPECT_FALSE(bag->is_empty(k)) << path;
    EXPECT_EQ(bag->first_stamp_ns(), 1'700'000'000'000'000'000) << path;
  }
}

// What is whole before the cut is used; never a crash. Which scans those are depends on the container.
TEST(Bag, CutAnywhereGivesWhatIsWhole) {
  std::mt19937 random(20);
  for (const std::string& path : all_bags()) {
    const std::string whole = content_of(path);
    std::size_t partly = 0;
    for (int k = 0; k < 100; ++k) {
      SCOPED_TRACE(path);
      const std::size_t size = 1 + random() % (whole.size() - 1);
      const TempFile file("cut.bag", whole.substr(0, size));
      try {
        const Drive drive = read_drive(file.path());
        ASSERT_LE(drive.scans.size(), 4u);
        expect_the_drive(drive, drive.scans.size());
        if (!drive.scans.empty() && drive.scans.size() < 4) ++partly;
        // All scans may lie before the cut: then only its end is missing, which is said all the same.
        EXPECT_GT(drive.warnings.broken_lines, 0u) << "cut to " << size << " of " << whole.size() << " bytes";
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
    // Of one chunk in a block of bz2, or of SQLite's pages without their tree, there is all or nothing.
    for (const char* of_small_chunks : {"mcap/none.mcap", "mcap/zstd.mcap", "mcap/unchunked.mcap"}) {
      EXPECT_TRUE(partly > 0 || !path.ends_with(of_small_chunks)) << path;
    }
  }
}

TEST(Bag, AFlippedByteIsNeverACrash) {
  std::mt19937 random(21);
  for (const std::string& path : all_bags()) {
    const std::string whole = content_of(path);
    for (int k = 0; k < 50; ++k) {
      std::string bytes = whole;
      for (int flips = 0; flips < 3; ++flips)
        bytes[random() % bytes.size()] ^= static_cast<char>(1 + random() % 255);
      const TempFile file("flipped.bag", bytes);
      try {
        (void)read_drive(file.path());
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
  }
}

TEST(Bag, AFolderIsItsBagsByTimeUnlessItsMetadataSay) {
  const TempFile place("folder");
  const std::string folder = place.path() + ".d";
  fs::create_directory(folder);
  expect_parts(error_of([&] { open_bag(folder); }), {"expected a bag, found a folder without any"});
  fs::copy_file(kCorpus + "mcap/zstd.mcap", folder + "/b.mcap");
  expect_the_drive(read_drive(folder), 4);
  std::ofstream(folder + "/metadata.yaml")
      << "rosbag2_bagfile_information:\n  relative_file_paths:\n    - elsewhere/b.mcap\n    - c.mcap\n";
  const Drive drive = read_drive(folder);
  fs::remove_all(folder);
  expect_the_drive(drive, 4);
  EXPECT_EQ(drive.warnings.broken_lines, 1u);
  ASSERT_FALSE(drive.warnings.messages.empty());
  expect_parts(drive.warnings.messages.front(), {"c.mcap"});
}

TEST(Bag, NamesWhatItDoesNotRead) {
  const TempFile old("old.bag", "#ROSBAG V1.2\nwhatever");
  expect_parts(error_of([&] { open_bag(old.path()); }),
               {"expected a ROS 1 bag of format 2.0, found '#ROSBAG V1.2'"});
  std::string bytes = content_of(kCorpus + "mcap/zstd.mcap");
  for (std::size_t at = 0; (at = bytes.find("zstd", at)) != std::string::npos;) bytes.replace(at, 4, "aes5");
  const TempFile strange("strange.mcap", bytes);
  const auto bag = open_bag(strange.path());
  ASSERT_FALSE(bag->faults().messages.empty());
  expect_parts(bag->faults().messages.front(), {"aes5"});
}

}  // namespace
}  // namespace parloc
