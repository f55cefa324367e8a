// Odometry made worse: each kind does what its name says, measured against the odometry as it was.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/error.h"
#include "common/math/portable64.h"
#include "common/simulator/corrupt_odometry.h"

namespace parloc {
namespace {

constexpr double kRadPerDeg = kPi / 180.0;
using Kind = CorruptionEvent::Kind;

/// 10 readings a second for ten minutes, every second one with a scan; drives at 0.5 m/s and turns by 0.1
/// rad/s, but stands from 100 s to 200 s.
std::vector<LogRecord> drive() {
  std::vector<LogRecord> records;
  Pose pose{1.0, 2.0, 0.3};
  for (int k = 0; k < 6000; ++k) {
    LogRecord record;
    record.kind = k % 2 == 0 ? RecordKind::scan : RecordKind::odometry;
    record.stamp_s = 0.1 * k;
    if (k > 0 && !(record.stamp_s > 100.0 && record.stamp_s <= 200.0))
      pose = compose(pose, {0.05, 0.0, 0.01});
    record.odometry = pose;
    records.push_back(record);
  }
  return records;
}

double turned_rad(const std::vector<LogRecord>& records) {
  double sum = 0.0;
  for (std::size_t k = 1; k < records.size(); ++k)
    sum += wrap64(records[k].odometry.theta_rad - records[k - 1].odometry.theta_rad);
  return sum;
}
double driven_m(const std::vector<LogRecord>& records) {
  double sum = 0.0;
  for (std::size_t k = 1; k < records.size(); ++k)
    sum += distance_m(records[k].odometry, records[k - 1].odometry);
  return sum;
}

struct Corrupted {
  std::vector<LogRecord> before = drive(), after = before;
  std::vector<CorruptionEvent> events;
  explicit Corrupted(const OdometryCorruption& c, std::uint64_t seed = 1)
      : events(corrupt_odometry(after, c, seed)) {}
  std::size_t count(Kind kind) const {
    std::size_t n = 0;
    for (const CorruptionEvent& e : events) n += e.kind == kind ? 1 : 0;
    return n;
  }
};

TEST(CorruptOdometry, NothingLeavesItAsItWas) {
  const Corrupted c({});
  EXPECT_TRUE(c.events.empty());
  for (std::size_t k = 0; k < c.before.size(); ++k) {
    EXPECT_NEAR(distance_m(c.before[k].odometry, c.after[k].odometry), 0.0, 1e-9);
    EXPECT_NEAR(turn_rad(c.before[k].odometry, c.after[k].odometry), 0.0, 1e-9);
    EXPECT_EQ(c.before[k].stamp_s, c.after[k].stamp_s);
  }
}

TEST(CorruptOdometry, SlipsAreOfTheirSizeAndRate) {
  OdometryCorruption how;
  how.slips_per_min = 6.0;
  how.least_slip_rad = 8.0 * kRadPerDeg, how.most_slip_rad = 20.0 * kRadPerDeg;
  how.least_slip_m = 0.2, how.most_slip_m = 0.5;
  const Corrupted c(how);
  EXPECT_GT(c.events.size(), 30u);  // 50 are expected: it stands for 100 s of 600 s
  EXPECT_LT(c.events.size(), 72u);
  EXPECT_GT(c.count(Kind::slip_rotation), 10u);
  EXPECT_GT(c.count(Kind::slip_translation), 10u);
  for (const CorruptionEvent& e : c.events) {
    EXPECT_FALSE(e.stamp_s > 100.2 && e.stamp_s < 200.0) << e.stamp_s;
    const bool rotation = e.kind == Kind::slip_rotation;
    EXPECT_GE(std::fabs(e.value), rotation ? how.least_slip_rad : how.least_slip_m);
    EXPECT_LE(std::fabs(e.value), rotation ? how.most_slip_rad : how.most_slip_m);
  }
  // Every step is the true one, but those with a slip, which differ by just that.
  std::size_t next = 0;
  for (std::size_t k = 1; k < c.before.size(); ++k) {
    const Pose was = relative(c.before[k].odometry, c.before[k - 1].odometry);
    const Pose is = relative(c.after[k].odometry, c.after[k - 1].odometry);
    double turn = 0.0, drive = 0.0;
    for (; next < c.events.size() && c.events[next].stamp_s == c.before[k].stamp_s; ++next)
      (c.events[next].kind == Kind::slip_rotation ? turn : drive) += c.events[next].value;
    EXPECT_NEAR(wrap64(is.theta_rad - was.theta_rad), turn, 1e-9);
    EXPECT_NEAR(is.x_m - was.x_m, drive, 1e-9);
  }
  EXPECT_EQ(next, c.events.size());
}

TEST(CorruptOdometry, HiddenMotionIsMissingFromTheOdometry) {
  OdometryCorruption how;
  how.hidden_per_min = 3.0;
  how.least_slip_m = 0.2, how.most_slip_m = 0.5;
  const Corrupted c(how);
  double hidden_m = 0.0, hidden_rad = 0.0;
  for (const CorruptionEvent& e : c.events)
    (e.kind == Kind::hidden_rotation ? hidden_rad : hidden_m) += e.value;
  EXPECT_GT(hidden_m, 10 * how.least_slip_m);
  EXPECT_NEAR(driven_m(c.before) - driven_m(c.after), hidden_m, 1e-6);
  EXPECT_NEAR(turned_rad(c.before) - turned_rad(c.after), hidden_rad, 1e-6);
}

TEST(CorruptOdometry, LateOdometryIsLate) {
  for (const double offset_s : {0.15, -0.1}) {
    OdometryCorruption how;
    how.offset_s = offset_s;
    const Corrupted c(how);
    for (std::size_t k = 100; k < 900; ++k) {
      if (c.before[k].kind != RecordKind::scan) {
        EXPECT_NEAR(distance_m(c.before[k].odometry, c.after[k].odometry), 0.0, 1e-9);
        continue;
      }
      // Half-way between two readings the pose is on the chord of an arc: 0.05 m x 0.01 rad / 8 off it.
      const double steps = offset_s / 0.1;
      const Pose there = compose(
          c.before[k].odometry, along_arc(Pose{-0.05 * std::cos(0.01), 0.05 * std::sin(0.01), -0.01}, steps));
      EXPECT_NEAR(distance_m(c.after[k].odometry, there), 0.0, 5e-4) << offset_s;
      EXPECT_NEAR(turn_rad(c.after[k].odometry, there), 0.0, 1e-9);
    }
  }
}

TEST(CorruptOdometry, AGyroDriftsWhileTheRobotStandsOnly) {
  OdometryCorruption how;
  how.gyro_drift_rad_per_s = 0.02 * kRadPerDeg;
  const Corrupted c(how);
  EXPECT_NEAR(turned_rad(c.after) - turned_rad(c.before), 100.0 * 0.02 * kRadPerDeg, 1e-3 * kRadPerDeg);
}

TEST(CorruptOdometry, ResetsGoToTheOrigin) {
  OdometryCorruption how;
  how.resets_per_min = 1.0;
  const Corrupted c(how);
  std::size_t resets = 0;
  for (std::size_t k = 1; k < c.after.size(); ++k)  // it may stand there
    resets +=
        distance_m(c.after[k].odometry, {}) == 0.0 && distance_m(c.after[k - 1].odometry, {}) > 0.0 ? 1 : 0;
  EXPECT_EQ(resets, c.events.size());
  EXPECT_GE(resets, 3u);
  EXPECT_LE(resets, 20u);
}

TEST(CorruptOdometry, ScaleDriftAndThinningDoWhatTheySay) {
  OdometryCorruption how;
  how.scale_translation = 1.05;
  how.drift_rad_per_m = 0.002;
  how.keep_every = 3;
  const Corrupted c(how);
  EXPECT_NEAR(driven_m(c.after) / driven_m(c.before), 1.05, 1e-3);
  EXPECT_NEAR(turned_rad(c.after) - turned_rad(c.before), 0.002 * driven_m(c.before), 1e-3);
  EXPECT_EQ(c.after.size(), c.before.size() - 2000u);
}

TEST(CorruptOdometry, NoiseGrowsWithTheRootOfTheWay) {
  OdometryCorruption how;
  how.noise_rotation_per_m = 0.02;
  double squares = 0.0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Corrupted c(how, seed);
    const double off = turned_rad(c.after) - turned_rad(c.before);
    squares += off * off / driven_m(c.before);
  }
  EXPECT_NEAR(std::sqrt(squares / kSeeds), 0.02, 0.003);  // 3 standard deviations of 200 draws
}

TEST(CorruptOdometry, ASeedMeansTheSameEventsAndOneKindLeavesAnothersAlone) {
  OdometryCorruption how;
  how.slips_per_min = 3.0;
  const Corrupted a(how), again(how), other(how, 2);
  ASSERT_EQ(a.events.size(), again.events.size());
  for (std::size_t k = 0; k < a.after.size(); ++k) {
    EXPECT_EQ(a.after[k].odometry.x_m, again.after[k].odometry.x_m);
    EXPECT_EQ(a.after[k].odometry.theta_rad, again.after[k].odometry.theta_rad);
  }
  EXPECT_NE(a.after.back().odometry.x_m, other.after.back().odometry.x_m);
  how.noise_rotation = 0.1;
  how.resets_per_min = 1.0;
  const Corrupted more(how);
  std::vector<double> slips_of_a, slips_of_more;
  for (const CorruptionEvent& e : a.events) slips_of_a.push_back(e.value);
  for (const CorruptionEvent& e : more.events)
    if (e.kind != Kind::reset) slips_of_more.push_back(e.value);
  EXPECT_EQ(slips_of_a, slips_of_more);
}

TEST(CorruptionText, IsReadWithItsUnits) {
  const OdometryCorruption c = corruption_from_text(
      "hide=3,slip_deg=8:20,slip_m=0.2:0.5,offset_ms=-150,thin=2,slip_kind=rotation,gyro_drift=60");
  EXPECT_EQ(c.hidden_per_min, 3.0);
  EXPECT_NEAR(c.least_slip_rad, 8.0 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(c.most_slip_rad, 20.0 * kRadPerDeg, 1e-12);
  EXPECT_EQ(c.least_slip_m, 0.2);
  EXPECT_EQ(c.most_slip_m, 0.5);
  EXPECT_NEAR(c.offset_s, -0.15, 1e-12);
  EXPECT_EQ(c.keep_every, 2);
  EXPECT_EQ(c.slip_kind, OdometryCorruption::Slip::rotation);
  EXPECT_NEAR(c.gyro_drift_rad_per_s, kRadPerDeg, 1e-12);
}

TEST(CorruptionText, NamesWhatIsWrong) {
  const auto message = [](const char* text) -> std::string {
    try {
      corruption_from_text(text);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message("hidden=3").find("'hide'"), std::string::npos) << message("hidden=3");
  EXPECT_NE(message("hide=3,hide=4").find("twice"), std::string::npos);
  EXPECT_NE(message("hide").find("key=value"), std::string::npos);
  EXPECT_NE(message("hide=-1").find("from 0 to"), std::string::npos);
  EXPECT_NE(message("slip_deg=20:8").find("smaller first"), std::string::npos);
  EXPECT_NE(message("slip_kind=up").find("rotation"), std::string::npos);
  EXPECT_NE(message("thin=0").find("whole number"), std::string::npos);
}

}  // namespace
}  // namespace parloc
