// `parloc slam` as a user calls it: its results, its live picture, and what it says when it cannot.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "common/io/trajectory.h"
#include "common/map/map_reader.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/decoded_png.h"

namespace parloc::test {
namespace {

/// A square room of 8 m with a pillar, seen by 91 beams over half a turn.
float range_m(double x, double y, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  double best = 20.0;
  const auto box = [&](double x0, double y0, double x1, double y1) {
    for (const double wall : {x0, x1}) {
      const double t = (wall - x) / c, at = y + t * s;
      if (t > 1e-9 && at >= y0 && at <= y1) best = std::min(best, t);
    }
    for (const double wall : {y0, y1}) {
      const double t = (wall - y) / s, at = x + t * c;
      if (t > 1e-9 && at >= x0 && at <= x1) best = std::min(best, t);
    }
  };
  box(0.0, 0.0, 8.0, 8.0);
  box(5.5, 5.0, 6.3, 5.4);
  return static_cast<float>(best);
}

std::string scan_line(double stamp_s, double x, double y, double theta) {
  std::string text = "FLASER 91";
  for (int k = 0; k < 91; ++k)
    text += ' ' + std::to_string(range_m(x, y, theta + (k - 45) * 3.14159265358979 / 90.0));
  const std::string pose = std::to_string(x) + ' ' + std::to_string(y) + ' ' + std::to_string(theta);
  const std::string stamp = std::to_string(stamp_s);
  return text + ' ' + pose + ' ' + pose + ' ' + stamp + " robot " + stamp + "\n";
}

constexpr int kScans = 60;

/// Along a bend, a scan every twentieth of the radius; odometry is exact.
std::string drive(int scans, double radius_m = 2.5) {
  std::string text;
  for (int k = 0; k < scans; ++k) {
    const double turn = 0.4 + 0.05 * k;
    text += scan_line(k, 4.0 + radius_m * std::sin(turn), 4.0 - radius_m * std::cos(turn), turn);
  }
  return text;
}

/// The same drive in a frame of its own.
Trajectory truth(int scans = kScans, double radius_m = 2.5) {
  Trajectory trajectory;
  for (int k = 0; k < scans; ++k) {
    const double turn = 0.4 + 0.05 * k;
    trajectory.push_back({1.0 * k, compose({30.0, -5.0, 1.0}, {4.0 + radius_m * std::sin(turn),
                                                               4.0 - radius_m * std::cos(turn), turn})});
  }
  return trajectory;
}

class SlamProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_slam_test");
    write("drive.log", drive(kScans));
    write_tum(path("truth.tum"), truth());
  }
  static Args slam(const std::string& out, const Args& more = {}, const std::string& log = "drive.log") {
    return with({"slam", "--log", path(log), "--out", path(out), "--backend", "cpu", "--threads", "1"}, more);
  }
  static std::set<std::string> names_in(const std::string& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder)))
      names.insert(entry.path().filename().string());
    return names;
  }
};

const std::set<std::string> kResults{"map.yaml",     "map.pgm",     "trajectory.tum",
                                     "metrics.json", "report.html", "picture.png"};

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST_F(SlamProgram, MakesAMapAndAReportThatShowsItGrow) {
  const Outcome o = done(slam("whole", {"--particles", "8", "--truth", path("truth.tum"), "--quiet"}));
  EXPECT_EQ(o.out + o.err, "");
  EXPECT_EQ(names_in("whole"), kResults);
  const GridMap map = read_map(path("whole/map.yaml"));
  EXPECT_GT(map.width, 150);  // 8 m of 5 cm
  EXPECT_LT(map.width, 260);
  const std::string page = read("whole/report.html");
  const std::size_t moments = count_of(page, "<g class=\"grown\"");
  EXPECT_GE(moments, 12u);
  EXPECT_LE(moments, 24u);
  EXPECT_EQ(count_of(page, "data:image/png;base64,"), moments + 1);
  expect_parts(page,
               {"How the map grew", "id=\"play\"", "Effective particles", "Ancestors of the last particles",
                "Tiles of all maps", "Time per step", "Error in heading", "distinct ancestors"});
  EXPECT_LT(page.size(), 1'000'000u);
}

TEST_F(SlamProgram, MetricsAgreeWithEachOther) {
  const Json m = told(slam("numbers", {"--particles", "8", "--truth", path("truth.tum"), "--json"}));
  EXPECT_EQ(m.at("scans"), kScans);
  const auto taken_in = m.at("scans_taken_in").get<std::size_t>();
  EXPECT_EQ(taken_in, 20u);  // every third: two steps are 0.2 mm short of slam.update_min_d
  const Json& scans = m.at("taken_in");
  for (const char* list : {"stamp_s", "n_eff", "resampled", "tiles", "handed_over", "step_ms"})
    EXPECT_EQ(scans.at(list).size(), taken_in) << list;
  EXPECT_EQ(m.at("distinct_ancestors").size(), taken_in);
  const auto n_eff = scans.at("n_eff").get<std::vector<double>>();
  EXPECT_EQ(m.at("n_eff").at("least"), *std::min_element(n_eff.begin(), n_eff.end()));
  EXPECT_LE(m.at("n_eff").at("least"), m.at("n_eff").at("mean"));
  const auto resampled = scans.at("resampled").get<std::vector<int>>();
  EXPECT_EQ(m.at("resampled"), std::accumulate(resampled.begin(), resampled.end(), 0));
  EXPECT_EQ(m.at("ancestors_at_quarters").size(), 4u);
  EXPECT_EQ(m.at("ancestors_at_quarters").at(0), m.at("distinct_ancestors").at(0));
  EXPECT_LE(m.at("step_ms_median"), m.at("step_ms_p99"));
  EXPECT_LE(m.at("step_ms_p99"), m.at("step_ms_max"));
  // 60 scans 2 * 2.5 m * sin(0.025) apart; the particles add noise of a centimetre per step.
  EXPECT_NEAR(m.at("distance_m").get<double>(), 59 * 5.0 * std::sin(0.025), 1.0);
  EXPECT_EQ(m.at("truth").at("compared"), kScans);
  EXPECT_LT(m.at("truth").at("position_rmse_m"), 0.10);  // two cells
  EXPECT_LT(m.at("truth").at("heading_rmse_rad"), 0.05);
  EXPECT_GT(m.at("truth").at("position_rmse_m"), 0.0);
}

TEST_F(SlamProgram, LiveChangesNoResult) {
  done(slam("plain", {"--particles", "8", "--quiet"}));
  const Outcome o = done(slam("watched", {"--particles", "8", "--live"}));
  expect_parts(o.err, {"see " + path("watched/live.html")});
  EXPECT_EQ(names_in("watched"), kResults);
  for (const char* file : {"/map.pgm", "/map.yaml", "/trajectory.tum"})
    EXPECT_EQ(read(std::string("watched") + file), read(std::string("plain") + file)) << file;
  EXPECT_EQ(json_of("watched/metrics.json").at("digest"), json_of("plain/metrics.json").at("digest"));
}

// 60 scans of 3000 particles take seconds; the live picture is there from the first scan on.
TEST_F(SlamProgram, TheLivePictureIsWholeWheneverItIsLookedAt) {
  const pid_t child = runner->start(slam("live", {"--particles", "3000", "--live"}));
  int looked = 0;
  bool page_seen = false;
  for (int k = 0; k < 6000 && looked < 25; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const std::string png = read("live/live.png");
    if (png.empty()) continue;
    const Picture picture = decode(png);
    EXPECT_GT(picture.width, 100);
    EXPECT_FALSE(picture.rgb.empty());
    page_seen = page_seen || read("live/live.html").find("live.png?") != std::string::npos;
    ++looked;
  }
  kill(child, SIGINT);
  const Outcome o = runner->finish(child);
  EXPECT_EQ(looked, 25);
  EXPECT_TRUE(page_seen);
  ASSERT_EQ(o.code, 130) << o.err;
  std::set<std::string> names = kResults;
  names.insert("checkpoint");  // to go on from
  EXPECT_EQ(names_in("live"), names);
  EXPECT_EQ(json_of("live/metrics.json").at("interrupted"), true);
  EXPECT_LT(read_tum(path("live/trajectory.tum")).size(), static_cast<std::size_t>(kScans));
}

TEST_F(SlamProgram, ARunThatWasKilledLeavesNoLivePictureToTheNext) {
  std::filesystem::create_directories(path("killed"));
  write("killed/live.png", "old");
  write("killed/live.html", "old");
  done(slam("killed", {"--particles", "2", "--quiet"}));
  EXPECT_EQ(names_in("killed"), kResults);
}

TEST_F(SlamProgram, OneScanMakesAMap) {
  write("one.log", drive(1));
  done(slam("one", {"--particles", "3", "--truth", path("truth.tum"), "--live", "--quiet"}, "one.log"));
  EXPECT_EQ(names_in("one"), kResults);
  EXPECT_EQ(count_of(read("one/report.html"), "<g class=\"grown\""), 1u);
  const Json m = json_of("one/metrics.json");
  EXPECT_EQ(m.at("scans_taken_in"), 1);
  EXPECT_EQ(m.at("truth").at("position_rmse_m"), nullptr);  // one place lies on any other
}

TEST_F(SlamProgram, ErrorsAreOneLineAndLeaveNothing) {
  write("file", "");
  write("empty.log", "");
  std::filesystem::create_directories(path("blocked/live.png"));
  for (const ProgramCase& c : {ProgramCase{slam("e1", {"--truth", path("none.tum")}), 3, "none.tum"},
                               ProgramCase{slam("e1", {"--live"}, "empty.log"), 3, "empty.log"},
                               ProgramCase{slam("file/below", {"--live"}), 5, "file/below"},
                               ProgramCase{slam("blocked", {"--live"}), 5, "blocked/live.png"},
                               ProgramCase{slam("e1", {"--particles", "0"}), 2,
                                           "--particles: expected a whole number from 1 to 65535"}})
    expect_error(call(c.args), c);
  EXPECT_FALSE(std::filesystem::exists(path("e1")));
}

// More than two rounds: the robot sees again what it saw, and the odometry is exact.
TEST_F(SlamProgram, LoopsAreClosedUnlessToldNotTo) {
  write("rounds.log", drive(300, 1.5));
  write_tum(path("rounds.tum"), truth(300, 1.5));
  write("open.yaml", "slam:\n  particles: 1\n  close_loops: false\n");
  const auto mapped = [](const std::string& out, const Args& more) {
    const Args rounds{"slam",   "--log",   path("rounds.log"), "--backend",
                      "cpu",    "--truth", path("rounds.tum"), "--out",
                      path(out)};
    return done(with(rounds, more));
  };
  const Outcome closed = mapped("closed", {"--particles", "1"});
  const Json metrics = json_of("closed/metrics.json"), loops = metrics.at("loops");
  EXPECT_GT(loops.at("used").get<int>(), 0);
  EXPECT_EQ(loops.at("found").get<int>(), loops.at("used").get<int>() + loops.at("refused").get<int>());
  // Half a cell: nothing is wrong with scans and odometry.
  EXPECT_LT(metrics.at("truth").at("position_rmse_m").get<double>(), 0.025);
  expect_parts(closed.out + closed.err, {"used; the way was moved by up to "});
  EXPECT_TRUE(metrics.at("config").at("slam").at("close_loops").get<bool>());
  const Outcome open = mapped("open", {"--config", path("open.yaml")});
  EXPECT_TRUE(json_of("open/metrics.json").at("loops").is_null());
  expect_none_of(open.out + open.err, {"loops"});
}

}  // namespace
}  // namespace parloc::test
