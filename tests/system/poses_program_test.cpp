// `parloc run --poses`: every scan's own answer beside the trajectory.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/map/map_reader.h"
#include "common/simulator/simulator.h"
#include "tests/system/program_fixture.h"
#include "tests/unit/localize_scenes.h"

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

class PosesProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_poses_program_test");
    write_file(path("bare.yaml"), "localize:\n  health: false\n");
    const GridMap room = bare_room();
    write_map(path("room.yaml"), room);
    std::string text;
    for (const LogRecord& r : drive(room, TrialTask::global, 3.0, 4).records)
      if (r.kind == RecordKind::scan) text += carmen_line(r) + "\n";
    write_file(path("room.log"), text);
  }
  static Outcome corridor(const Args& more) {
    return call(
        with({"run", "--map", "maps/malaga_corridor.yaml", "--log", "maps/logs/malaga_corridor.log.gz",
              "--init", "3.453,-10.171,-0.485", "--backend", "cpu", "--quiet", "--out", path("out")},
             more));
  }
  static std::vector<std::vector<std::string>> rows(const std::string& name, char separator) {
    std::istringstream text(read(name));
    std::vector<std::vector<std::string>> found;
    for (std::string line; std::getline(text, line);) {
      if (line[0] == '#') continue;
      std::istringstream cells(line + separator);
      found.emplace_back();
      for (std::string cell; std::getline(cells, cell, separator);) found.back().push_back(cell);
    }
    return found;
  }
  static std::vector<Json> objects(const std::string& name) {
    std::istringstream text(read(name));
    std::vector<Json> found;
    for (std::string line; std::getline(text, line);) found.push_back(Json::parse(line));
    return found;
  }
  static std::string rounded(const std::string& number) {
    return fmt::format("{:.6f}", std::strtod(number.c_str(), nullptr));
  }
};

TEST_F(PosesProgram, ARowPerScanAgreesWithTheTrajectoryToTheDigit) {
  ASSERT_EQ(corridor({}).code, 0);
  const auto poses = rows("out/poses.csv", ',');
  const auto trajectory = rows("out/trajectory.tum", ' ');
  ASSERT_EQ(poses.size(), trajectory.size() + 1);
  ASSERT_EQ(trajectory.size(), json_of("out/metrics.json").at("scans"));
  const std::size_t columns = poses[0].size();
  EXPECT_EQ(poses[0][0], "stamp_s");
  EXPECT_EQ(poses[0][10], "state");
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    const std::vector<std::string>& row = poses[k + 1];
    ASSERT_EQ(row.size(), columns);
    ASSERT_EQ(row[0], trajectory[k][0]);
    ASSERT_EQ(rounded(row[1]), trajectory[k][1]);
    ASSERT_EQ(rounded(row[2]), trajectory[k][2]);
    ASSERT_EQ(row[10], "tracking");
  }

  ASSERT_EQ(corridor({"--poses", "jsonl"}).code, 0);
  EXPECT_FALSE(fs::exists(path("out/poses.csv")));  // none of an earlier run stays among the others
  const std::vector<Json> said = objects("out/poses.jsonl");
  ASSERT_EQ(said.size(), trajectory.size());
  EXPECT_EQ(said.back().at("x_m").get<double>(), std::strtod(poses.back()[1].c_str(), nullptr));
  EXPECT_EQ(said.back().at("probability").get<double>(), std::strtod(poses.back()[11].c_str(), nullptr));
}

TEST_F(PosesProgram, TheBareFilterIsNotJudgedAndNoneIsNone) {
  ASSERT_EQ(corridor({"--config", path("bare.yaml")}).code, 0);
  const auto poses = rows("out/poses.csv", ',');
  ASSERT_GT(poses.size(), 2u);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    for (const std::size_t judged : {10u, 11u, 12u}) ASSERT_EQ(poses[k][judged], "");
    ASSERT_GT(std::strtod(poses[k][13].c_str(), nullptr), 1.0);  // N_eff
  }
  ASSERT_EQ(corridor({"--odometry-only"}).code, 0);
  for (const auto& row : rows("out/poses.csv", ',')) {
    if (row[0] == "stamp_s") continue;
    ASSERT_EQ(row[15], "0");  // beams used
    ASSERT_EQ(row[16], "0");  // weighted
  }
  ASSERT_EQ(corridor({"--poses", "none"}).code, 0);
  EXPECT_FALSE(fs::exists(path("out/poses.csv")));
  expect_one_line(corridor({"--poses", "xml"}), 2, "--poses");
}

TEST_F(PosesProgram, TheHypothesesOfAnAmbiguousPlaceAreListed) {
  const Outcome o = call({"run", "--map", path("room.yaml"), "--log", path("room.log"), "--init", "global",
                          "--backend", "cpu", "--quiet", "--out", path("two"), "--poses", "jsonl"});
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Json> said = objects("two/poses.jsonl");
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front().at("searched"), true);
  const Json& last = said.back();
  EXPECT_EQ(last.at("state"), "ambiguous");
  EXPECT_EQ(last.at("hypotheses"), json_of("two/metrics.json").at("health").at("end_modes"));
  EXPECT_GE(last.at("hypotheses").size(), 2u);
}

TEST_F(PosesProgram, AFolderInTheWayIsSaidBeforeTheWork) {
  for (const char* name : {"poses.csv", "poses.jsonl"}) {
    fs::create_directories(path(std::string("blocked_") + name + "/" + name + "/inside"));
    const Outcome o =
        call({"run", "--map", "maps/malaga_corridor.yaml", "--log", "maps/logs/malaga_corridor.log.gz",
              "--init", "3.453,-10.171,-0.485", "--out", path(std::string("blocked_") + name)});
    expect_one_line(o, 5, "cannot be written");
  }
}

}  // namespace
}  // namespace parloc::test
