// `parloc slam` on logs without odometry, with gaps, and with odd time stamps.
#include <gtest/gtest.h>

#include "common/map/map_reader.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/real_data.h"
#include "tests/unit/simulated.h"

namespace parloc::test {
namespace {

using Scans = std::vector<LogRecord>;

/// 17 m through the hall of the paper with its noise, every third scan.
const SimulatedLog& hall_drive() {
  static const SimulatedLog log = [] {
    Scenario s = paper();
    s.seed = 3;
    s.scan_rate_hz /= 3.0;
    return simulate(s, fine_hall());
  }();
  return log;
}

std::string log_of(Scans scans, const std::function<void(Scans&)>& change) {
  change(scans);
  std::string text;
  for (const LogRecord& r : scans) text += carmen_line(r) + "\n";
  return text;
}
void still(Scans& scans) {
  for (LogRecord& r : scans) r.odometry = {};
}
/// In the middle two seconds are missing, and a minute goes by.
void gap(Scans& scans) {
  const auto middle = scans.begin() + static_cast<std::ptrdiff_t>(scans.size() / 2);
  const auto after = scans.erase(middle, middle + 7);
  for (auto r = after; r != scans.end(); ++r) r->stamp_s = r->scan.stamp_s = r->stamp_s + 58.0;
}
void duplicated(Scans& scans) {
  Scans twice;
  for (std::size_t k = 0; k < scans.size(); ++k) twice.insert(twice.end(), k % 5 == 0 ? 2 : 1, scans[k]);
  scans = twice;
}
/// In the middle the driver starts again, and its odometry at its origin.
void restarted(Scans& scans) {
  const std::size_t middle = scans.size() / 2;
  const Pose there = scans[middle].odometry;
  for (std::size_t k = middle; k < scans.size(); ++k) scans[k].odometry = relative(scans[k].odometry, there);
}
void backward(Scans& scans) {
  for (std::size_t k = 5; k < scans.size(); k += 7) {
    scans[k].stamp_s -= 0.9;
    scans[k].scan.stamp_s -= 0.9;
  }
}

class SlamOdometryProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_slam_odometry_test");
    write_tum(path("truth.tum"), hall_drive().truth);
    write("clean.log", log_of(scans_of(hall_drive()), [](Scans&) {}));
    done(slam("clean"));
  }
  static Args slam(const std::string& name, const Args& more = {}, const std::string& out = {}) {
    return with({"slam", "--log", path(name + ".log"), "--out", path(out.empty() ? name : out), "--truth",
                 path("truth.tum"), "--backend", "cpu", "--particles", "15", "--quiet"},
                more);
  }
  /// Of the one's walls, how many lie within 0.15 m of one of the other's.
  static double walls_shared(const std::string& one, const std::string& other) {
    const GridMap a = read_map(path(one + "/map.yaml")), b = read_map(path(other + "/map.yaml"));
    const auto near = [&](double x_m, double y_m) {
      for (int j = -3; j <= 3; ++j)
        for (int i = -3; i <= 3; ++i)
          if (b.at_point(x_m + 0.05 * i, y_m + 0.05 * j) == Cell::occupied) return true;
      return false;
    };
    double walls = 0.0, shared = 0.0;
    for (std::int32_t j = 0; j < a.height; ++j)
      for (std::int32_t i = 0; i < a.width; ++i) {
        if (a.at(i, j) != Cell::occupied) continue;
        const Pose at = compose(a.T_map_grid, {(i + 0.5) * a.resolution_m, (j + 0.5) * a.resolution_m, 0.0});
        walls += 1.0;
        shared += near(at.x_m, at.y_m) ? 1.0 : 0.0;
      }
    return shared / walls;
  }
  /// Makes a map of the changed drive; it must be that of the clean one, give or take what particles differ
  /// by (0.1 m, as tests/unit/grid_slam_test.cpp, and three cells).
  static Json mapped(const std::string& name, const std::function<void(Scans&)>& change,
                     const std::string& words = {}) {
    write(name + ".log", log_of(scans_of(hall_drive()), change));
    expect_parts(done(slam(name)).err, {words});
    EXPECT_GT(walls_shared(name, "clean"), 0.95) << name;
    EXPECT_GT(walls_shared("clean", name), 0.95) << name;
    return json_of(name + "/metrics.json");
  }
  static double error_m(const Json& m) { return m.at("truth").at("position_rmse_m").get<double>(); }
};

TEST_F(SlamOdometryProgram, TheCleanLogHasNothingToWarnOf) {
  const Json m = json_of("clean/metrics.json");
  EXPECT_EQ(m.at("odometry").at("from"), "recorded");
  EXPECT_EQ(m.at("warnings").at("repeated_stamps"), 0);
  EXPECT_EQ(m.at("warnings").at("gaps"), 0);
  EXPECT_LT(error_m(m), 0.10);
}

TEST_F(SlamOdometryProgram, OdometryThatNeverMovesIsTakenFromTheScans) {
  const Json m = mapped("still", still, "the log has no odometry that moves: taken from its scans");
  EXPECT_EQ(m.at("odometry").at("from"), "scans");
  EXPECT_EQ(m.at("odometry").at("recorded_never_moves"), true);
  EXPECT_EQ(m.at("odometry").at("new_maps"), 0);
  EXPECT_EQ(m.at("config").at("slam").at("odometry"), "scans");
  EXPECT_GT(m.at("scans_taken_in"), 40);
  EXPECT_LT(error_m(m), 0.12);
  expect_parts(read("still/report.html"), {"no odometry that moves"});
}

TEST_F(SlamOdometryProgram, ItIsTheSameAsAskedForAndAtAnyNumberOfThreads) {
  write("scans.yaml", "slam: {odometry: scans}\n");
  write("still.log", log_of(scans_of(hall_drive()), still));
  done(slam("still", {"--threads", "1"}));
  const Json chosen = json_of("still/metrics.json");
  EXPECT_EQ(done(slam("clean", {"--config", path("scans.yaml"), "--threads", "3"}, "asked")).err, "");
  const Json asked = json_of("asked/metrics.json");
  EXPECT_EQ(asked.at("digest"), chosen.at("digest"));
  EXPECT_EQ(asked.at("odometry").at("recorded_never_moves"), false);
}

TEST_F(SlamOdometryProgram, GapsAreCounted) {
  const Json m = mapped("gap", gap);
  EXPECT_EQ(m.at("warnings").at("gaps"), 1);
  expect_parts(read("gap/report.html"), {"1 gaps of more than 5 s between scans, the longest 60"});
  EXPECT_EQ(mapped("still_gap", [](Scans& s) { gap(s), still(s); }).at("odometry").at("new_maps"), 0);
}

TEST_F(SlamOdometryProgram, RepeatedScansAreCounted) {
  const std::size_t repeated = (scans_of(hall_drive()).size() + 4) / 5;
  EXPECT_EQ(mapped("twice", duplicated).at("warnings").at("repeated_stamps"), repeated);
  EXPECT_EQ(error_m(json_of("twice/metrics.json")) < 0.10, true);
  mapped("still_twice", [](Scans& s) { duplicated(s), still(s); });
}

TEST_F(SlamOdometryProgram, StampsThatGoBackAreCounted) {
  EXPECT_GT(mapped("back", backward).at("warnings").at("backward_stamps"), 10);
  EXPECT_EQ(mapped("still_back", [](Scans& s) { backward(s), still(s); }).at("odometry").at("new_maps"), 0);
}

TEST_F(SlamOdometryProgram, OdometryThatStartsAgainIsOneJump) {
  const Json m = mapped("restarted", restarted);
  EXPECT_EQ(m.at("warnings").at("odometry_jumps"), 1);
  EXPECT_EQ(json_of("clean/metrics.json").at("warnings").at("odometry_jumps"), 0);
  EXPECT_LT(error_m(m), 0.10);
  expect_parts(read("restarted/report.html"), {"1 jumps of the odometry"});
}

// The first five minutes of Intel, its odometry struck out. Relations: 0.07 m is the published RBPF's figure
// with odometry, for the whole log.
TEST_F(SlamOdometryProgram, IntelWithoutOdometry) {
  const std::string log = real_data("intel/scans.log"), relations = real_data("intel/relations.txt");
  PARLOC_NEEDS_FILE(log);
  PARLOC_NEEDS_FILE(relations);
  std::ofstream out(path("intel.log"));
  const auto reader = open_carmen_log(log);
  LogRecord r;
  double first_s = -1.0;
  while (reader->next(r)) {
    if (r.kind != RecordKind::scan) continue;
    if (first_s < 0.0) first_s = r.stamp_s;
    if (r.stamp_s > first_s + 300.0) break;
    std::string ranges;
    for (const float v : r.scan.ranges_m) ranges += ' ' + std::to_string(v);
    const std::string stamp = std::to_string(r.stamp_s);
    out << "FLASER " << r.scan.ranges_m.size() << ranges << " 0 0 0 0 0 0 " << stamp << " h " << stamp
        << "\n";
  }
  out.close();
  write("intel.yaml", "scan: {laser_max_range: 80}\n");
  done({"slam", "--log", path("intel.log"), "--relations", relations, "--config", path("intel.yaml"), "--out",
        path("intel"), "--backend", "cpu", "--particles", "15", "--quiet"});
  const Json m = json_of("intel/metrics.json");
  EXPECT_EQ(m.at("odometry").at("recorded_never_moves"), true);
  EXPECT_EQ(m.at("odometry").at("new_maps"), 0);
  EXPECT_GT(m.at("relations").at("compared"), 100);
  EXPECT_LT(m.at("relations").at("translation_mean_m"), 0.07);
}

}  // namespace
}  // namespace parloc::test
