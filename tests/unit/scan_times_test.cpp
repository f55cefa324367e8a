// What is odd about the stamps of a log's scans, and what is not.
#include "tools/program/scan_times.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace parloc::tools {
namespace {

/// `count` scans at 10 Hz; the stamp of scan k is stamp_of(its true time).
template <class StampOf>
ScanTimes times_of(int count, const StampOf& stamp_of) {
  ScanTimes times;
  for (int k = 0; k < count; ++k) times.add("front", stamp_of(1.7e9 + 0.1 * k));
  return times;
}

TEST(ScanTimes, StampsThatStandStillAreSaidOnce) {
  EXPECT_EQ(times_of(100, [](double) { return 0.0; }).trouble(),
            "stamps stand still: 99 of 100 scans have the stamp of the scan before; times are guessed "
            "(0.1 s each)");
  // A clock that dies after a while does not go on in blocks.
  const ScanTimes dies = times_of(100, [](double t_s) { return std::min(t_s, 1.7e9 + 1.95); });
  EXPECT_EQ(dies.trouble().rfind("stamps stand still: 79 of 100 scans", 0), 0u) << dies.trouble();
}

TEST(ScanTimes, RoundedStampsAreToldFromThoseThatStandStill) {
  const ScanTimes rounded = times_of(100, [](double t_s) { return std::floor(t_s); });
  EXPECT_EQ(rounded.repeated(), 90u);
  EXPECT_EQ(rounded.trouble(),
            "stamps look rounded: 90 of 100 scans have the stamp of the scan before, then come steps of 1 s "
            "or more; times between are guessed (0.1 s each)");
  // Of single precision, which has steps of 128 s there.
  const ScanTimes single =
      times_of(5000, [](double t_s) { return static_cast<double>(static_cast<float>(t_s)); });
  EXPECT_EQ(single.trouble().rfind("stamps look rounded: ", 0), 0u) << single.trouble();
  EXPECT_NE(single.trouble().find("steps of 128 s"), std::string::npos) << single.trouble();
}

TEST(ScanTimes, AFewEqualStampsAreNoTrouble) {
  for (const int together : {1, 2, 3}) {
    ScanTimes times;
    for (int k = 0; k < 90; ++k) times.add("front", 0.1 * (k / together));
    EXPECT_EQ(times.trouble(), "") << together;
    EXPECT_EQ(times.repeated(), static_cast<std::size_t>(90 - 90 / together));
  }
  ScanTimes lidars;  // their own, at the same time
  for (int k = 0; k < 30; ++k)
    for (const char* name : {"front", "rear", "left", "right", "top"}) lidars.add(name, 0.1 * k);
  EXPECT_EQ(lidars.repeated(), 0u);
  EXPECT_EQ(lidars.trouble(), "");
  EXPECT_EQ(ScanTimes().trouble(), "");
}

}  // namespace
}  // namespace parloc::tools
