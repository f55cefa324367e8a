// `parloc run` without a start pose, and what it says when it does not know where the robot is.
#include <gtest/gtest.h>

#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/localize_scenes.h"

namespace parloc::test {
namespace {

class RunGlobal : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_run_global_test");
    write("bare.yaml", "localize:\n  health: false\n");
    write("no_slips.yaml", "localize:\n  slips: false\n");
    write("watch.yaml", "localize:\n  recover: false\n");
    const GridMap room = bare_room();
    write_map(path("room.yaml"), room);
    std::string text;
    for (const LogRecord& r : drive(room, TrialTask::global, 4.0, 4).records)
      if (r.kind == RecordKind::scan) text += carmen_line(r) + "\n";
    write("room.log", text);
  }
  /// On the shipped corridor, a real log.
  static Args corridor(const Args& more, const std::string& map = "maps/malaga_corridor.yaml") {
    return run(map, "maps/logs/malaga_corridor.log.gz", more);
  }
  static Args room(const Args& more) { return run(path("room.yaml"), path("room.log"), more); }
  static Json metrics() { return json_of("out/metrics.json"); }

 private:
  static Args run(const std::string& map, const std::string& log, const Args& more) {
    return with({"run", "--map", map, "--log", log, "--backend", "cpu", "--out", path("out")}, more);
  }
};

const Args kTruth{"--truth", "maps/logs/malaga_corridor.tum"};

TEST_F(RunGlobal, FindsTheStartOfARealLog) {
  expect_parts(done(corridor(with(kTruth, {"--init", "global", "--strict"}))).out, {"\nhealth "});
  const Json m = metrics();
  EXPECT_LT(m.at("position_max_m").get<double>(), 0.3);  // the reference is good to 3 cm, the map has 5
  const Json& health = m.at("health");
  EXPECT_EQ(health.at("end_state"), "tracking");
  EXPECT_GT(health.at("end_probability").get<double>(), 0.8);
  EXPECT_GE(health.at("searches").get<int>(), 1);
  EXPECT_NEAR(health.at("share_tracking").get<double>() + health.at("share_ambiguous").get<double>() +
                  health.at("share_lost").get<double>(),
              1.0, 1e-12);
  EXPECT_TRUE(health.at("end_modes").empty());
  expect_parts(read("out/report.html"), {"probability of being right"});

  const Args near{"--init", "global", "--near", "3.4,-10.1,2", "--heading", "-0.5,0.4", "--quiet"};
  done(corridor(with(kTruth, near)));
  EXPECT_LT(metrics().at("position_max_m").get<double>(), 0.3);
  EXPECT_EQ(metrics().at("init"), "global near 3.4,-10.1,2 heading -0.5,0.4");
}

TEST_F(RunGlobal, AKnownStartIsNotSearchedAndTheBareFilterSaysTheSame) {
  const Args start{"--init", "3.453,-10.171,-0.485", "--quiet"};
  done(corridor(with(start, {"--config", path("no_slips.yaml")})));
  const Json judged = metrics();
  EXPECT_EQ(judged.at("health").at("searches"), 0);
  EXPECT_EQ(judged.at("health").at("share_tracking"), 1.0);
  done(corridor(with(start, {"--config", path("bare.yaml")})));
  EXPECT_TRUE(metrics().at("health").is_null());
  EXPECT_EQ(metrics().at("digest"), judged.at("digest"));
  done(corridor(with(start, {"--odometry-only"})));
  EXPECT_TRUE(metrics().at("health").is_null());
}

TEST_F(RunGlobal, TheRightOneOfSeveralCandidatesWins) {
  done(corridor(with(kTruth, {"--init", "5,-10,1", "--init", "3.453,-10.171,-0.485"})));
  EXPECT_EQ(metrics().at("health").at("end_state"), "tracking");
  EXPECT_LT(metrics().at("position_max_m").get<double>(), 0.3);
}

// A wrong map: nothing fits. The results are written all the same, and the last line says it.
TEST_F(RunGlobal, AWrongMapIsSaidInOneLine) {
  const Args wrong{"--init", "5,5,0", "--config", path("watch.yaml"), "--quiet"};
  const Outcome o = call(corridor(wrong, "maps/office.yaml"));
  expect_one_line(o, 0, "");
  EXPECT_EQ(o.err.rfind("parloc: LOST at the end: ", 0), 0u) << o.err;
  EXPECT_EQ(metrics().at("health").at("end_state"), "lost");
  EXPECT_EQ(metrics().at("health").at("searches"), 0);  // localize.recover is false
  EXPECT_EQ(call(corridor(with(wrong, {"--strict"}), "maps/office.yaml")).code, 7);
}

TEST_F(RunGlobal, ASymmetricRoomIsAmbiguousAndBothPlacesAreNamed) {
  const Outcome o = done(room({"--init", "global", "--quiet"}));
  EXPECT_EQ(o.err.rfind("parloc: AMBIGUOUS at the end: ", 0), 0u) << o.err;
  const Json health = metrics().at("health");
  EXPECT_EQ(health.at("end_state"), "ambiguous");
  EXPECT_GE(health.at("end_modes").size(), 2u);
  EXPECT_EQ(health.at("share_tracking"), 0.0);
  EXPECT_EQ(call(room({"--init", "global", "--quiet", "--strict"})).code, 7);
}

TEST_F(RunGlobal, PriorsNeedASearch) {
  for (const Args& bad :
       {Args{"--init", "1,2,0", "--near", "1,2,3"}, Args{"--init", "global", "--near", "1,2"},
        Args{"--init", "global", "--heading", "0,-1"}, Args{"--init", "global", "--init", "1,2,0"},
        Args{"--init", "global", "--near", "1,2,3", "--config", path("bare.yaml")}})
    expect_one_line(call(corridor(bad)), 2, "");
  const Outcome nowhere = call(corridor({"--init", "global", "--near", "500,500,1", "--quiet"}));
  EXPECT_EQ(nowhere.code, 3);
  expect_parts(nowhere.err, {"no free cell"});
}

}  // namespace
}  // namespace parloc::test
