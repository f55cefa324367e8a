// `parloc evaluate --families` as a person or a script meets it: the same for any number of jobs and alone,
// both sources of drives, and what is wrong on the command line.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

class FamiliesProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() { open("parloc_families_test"); }
  static Outcome evaluate(const Args& args) { return call(with({"evaluate", "--particles", "300"}, args)); }
  static Json result(const std::string& folder) { return json_of(folder + "/families.json"); }
};

// The family whose drives go through one small map that is made for each.
const Args kCorridors{"--families", "--family", "corridor", "--trials", "3"};

TEST_F(FamiliesProgram, TheNumberOfJobsChangesNothing) {
  const Outcome one =
      evaluate(with(kCorridors, {"--jobs", "1", "--out", path("one"), "--samples", path("one.csv")}));
  ASSERT_EQ(one.code, 0) << one.err;
  const Outcome two = evaluate(
      with(kCorridors, {"--jobs", "2", "--out", path("two"), "--samples", path("two.csv"), "--quiet"}));
  ASSERT_EQ(two.code, 0) << two.err;
  EXPECT_EQ(two.out + two.err, "");
  EXPECT_EQ(lasting(result("one")), lasting(result("two")));
  EXPECT_EQ(read("one.csv"), read("two.csv"));
  const Json j = result("one");
  ASSERT_EQ(j["drives"].size(), 3u);
  EXPECT_EQ(j["families"].size(), 1u);
  EXPECT_EQ(j["families"][0]["family"], "corridor");
  EXPECT_EQ(j["families"][0]["drives"], 3);
  EXPECT_GE(j["drives"][0]["parameters"]["corridor_width_m"].get<double>(), 1.5);
  EXPECT_NE(one.out.find("no worse"), std::string::npos) << one.out;
  const std::string page = read("one/report.html");
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos);  // nothing from elsewhere
  const std::string csv = read("one.csv");
  EXPECT_EQ(csv.rfind("family,seed,run,stamp_s,", 0), 0u);
  std::size_t scans = 0;
  for (const Json& drive : j["drives"])
    scans += drive["loop"]["samples"].get<std::size_t>() + drive["bare"]["samples"].get<std::size_t>();
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), 1 + scans);
}

TEST_F(FamiliesProgram, ASeedAloneIsTheSameDrive) {
  ASSERT_EQ(evaluate(with(kCorridors, {"--quiet", "--out", path("all")})).code, 0);
  const Args third{"--family", "corridor", "--seed", "3", "--trials", "1", "--quiet", "--out", path("alone")};
  ASSERT_EQ(evaluate(third).code, 0);
  EXPECT_EQ(result("all")["drives"][2], result("alone")["drives"][0]);
}

TEST_F(FamiliesProgram, ALogWithOdometryMadeWorse) {
  const Outcome o = evaluate(with(kLog, {"--families", "--corrupt", "slips=30,slip_deg=5:10", "--trials", "2",
                                         "--duration", "20", "--out", path("log")}));
  ASSERT_EQ(o.code, 0) << o.err;
  const Json j = result("log");
  ASSERT_EQ(j["drives"].size(), 2u);
  EXPECT_EQ(j["drives"][0]["family"], "slips=30,slip_deg=5:10");
  EXPECT_GT(j["drives"][0]["events"].get<int>(), 1);
  EXPECT_NE(j["drives"][0], j["drives"][1]);
  EXPECT_NEAR(j["drives"][0]["driven_s"].get<double>(), 20.0, 2.0);
  // As recorded, it is tracked.
  ASSERT_EQ(evaluate(with(kLog, {"--families", "--trials", "1", "--quiet", "--out", path("plain")})).code, 0);
  EXPECT_EQ(result("plain")["drives"][0]["events"], 0);
  EXPECT_EQ(result("plain")["drives"][0]["bare"]["within"], 1.0);
}

TEST_F(FamiliesProgram, CtrlCKeepsWhatIsDone) {
  broken_off({"evaluate", "--particles", "300", "--family", "corridor", "--trials", "400", "--jobs", "2",
              "--out", path("broken")},
             "of 400 drives");
  const Json j = result("broken");
  EXPECT_TRUE(j["interrupted"]);
  EXPECT_GE(j["drives"].size(), 1u);
  EXPECT_EQ(j["families"][0]["drives"], j["drives"].size());
}

TEST_F(FamiliesProgram, ErrorsAreOneLineWithACode) {
  const std::string log = kLog[1], map = kLog[3], truth = kLog[5];
  const ProgramCase cases[] = {
      {{"--family", "slipz"}, 2, "'slips'"},
      {{"--families", "--trials", "0"}, 2, "--trials"},
      {{"--families", "--maps", path("missing")}, 3, "missing"},
      {{"--families", "--scenario", "x.yaml"}, 2, "--scenario"},
      {{"--families", "--truth", truth}, 2, "--log"},
      {{"--families", "--log", log, "--map", map}, 2, "--truth"},
      {{"--family", "slips", "--log", log, "--map", map, "--truth", truth}, 2, "--family"},
      {with(kLog, {"--corrupt", "hidden=3"}), 2, "'hide'"},
      {with(kLog, {"--corrupt", "hide=x"}), 2, "hide"},
      {{"--families", "--out", "/dev/null/x"}, 5, "/dev/null/x"},
      {{"--families", "--samples", "/dev/null/x.csv"}, 5, "/dev/null/x.csv"},
  };
  for (const ProgramCase& c : cases) expect_error(evaluate(c.args), c);
}

}  // namespace
}  // namespace parloc::test
