// `parloc evaluate --relations` as a person or a script meets it: answers known by hand, the files, the
// published figures beside, and what is wrong with command line and files.
#include <gtest/gtest.h>

#include "tests/system/program_fixture.h"
#include "tests/unit/real_data.h"
#include "tests/unit/small_drive.h"

namespace parloc::test {
namespace {

class RelationsProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_relations_test");
    // Time runs backwards, and the last row repeats a stamp.
    write("way.tum",
          "# timestamp x y z qx qy qz qw\n3 0 0 0 0 0 0 1\n1.5 1.03 0.04 0 0 0 0 1\n"
          "9.25 1.08 3.16 0 0 0 0.7071068 0.7071068\n3 8 8 0 0 0 0 1\n");
    // Off by 3-4-5 and 5-12-13; the second turned by 0.1 rad too much; the third has no pose at 2 s.
    write("relations.txt", "3 1.5 1 0 0 0 0 0\n1.5 9.25 0 3 0 0 0 1.4707963268\n2 9.25 1 0 0 0 0 0\n");
    write("elsewhen.txt", "100 101 1 0 0 0 0 0\n3 102 1 0 0 0 0 0\n");
    write("empty.txt", "# none\n");
    write("junk.txt", "3 1.5 1 0 0 0 0 0\n1.5 9.25 0 3 0 0 0 1.47 and more\n");
    write("nan.txt", "3 1.5 nan 0 0 0 0 0\n");
    write("nan.tum", "3 0 0 0 0 0 0 1\n4 nan 0 0 0 0 0 1\n");
    write("junk.tum", "3 0 0 0 0 0 0 1 0.5\n");
    write("empty.tum", "");
  }
  static Args judge(const std::string& trajectory, const std::string& relations, const Args& more = {}) {
    return with({"evaluate", "--trajectory", trajectory, "--relations", relations}, more);
  }
};

TEST_F(RelationsProgram, AnswersKnownByHand) {
  const Json j = told(judge(path("way.tum"), path("relations.txt"), {"--json"})), e = j.at("relations");
  EXPECT_EQ(e.at("compared"), 2);
  EXPECT_EQ(e.at("without_pose"), 1);
  EXPECT_EQ(j.at("trajectory").at("poses"), 4);
  EXPECT_EQ(j.at("trajectory").at("repeated_stamps"), 1);
  const double digits = 1e-9;  // of the relation's yaw
  EXPECT_NEAR(e.at("translation_mean_m"), 0.09, digits);
  EXPECT_NEAR(e.at("translation_std_m"), 0.04, digits);
  EXPECT_NEAR(e.at("translation_rmse_m"), std::sqrt(0.0097), digits);
  EXPECT_NEAR(e.at("translation_median_m"), 0.09, digits);
  EXPECT_NEAR(e.at("translation_max_m"), 0.13, digits);
  EXPECT_NEAR(e.at("rotation_mean_rad"), 0.05, digits);
  EXPECT_NEAR(e.at("rotation_max_rad"), 0.1, digits);
  EXPECT_NEAR(j.at("largest").at(0).at("translation_m"), 0.13, digits);
  EXPECT_EQ(j.at("largest").at(0).at("stamp_2_s"), 9.25);
  EXPECT_EQ(j.at("largest").size(), 2u);
}

TEST_F(RelationsProgram, TableAndFiles) {
  const Outcome o =
      done(judge(path("way.tum"), path("relations.txt"), {"--dataset", "intel", "--out", path("judged")}));
  expect_parts(o.out, {"2 of 3 have both poses", "translation [m]  0.0900  0.0400  0.0985  0.0900  0.1300",
                       "rotation [deg]     2.86    2.86", "0.090 +- 0.040", "0.220 +- 0.296",
                       "0.070 +- 0.083", "0.031 +- 0.026", "Kuemmerle et al. 2009",
                       "1 pose has the stamp of an earlier one", "report.html"});
  expect_none_of(o.out, {"aces"});
  const Json j = json_of("judged/relations.json");
  EXPECT_EQ(j.at("dataset"), "intel");
  EXPECT_EQ(j.at("published").at("figures").size(), 3u);
  const std::string page = read("judged/report.html");
  expect_parts(page, {"graph mapping: published mean", "<title>0.130 m, 5.73 degrees</title>", "</html>"});
  expect_none_of(page, {"http"});  // nothing from elsewhere
}

TEST_F(RelationsProgram, WithoutADatasetAllThatAreKnownArePrinted) {
  const Outcome o = done(judge(path("way.tum"), path("relations.txt")));
  expect_parts(o.out, {"aces", "intel", "mit_killian", "mit_csail", "freiburg_079", "freiburg_hospital"});
  expect_none_of(o.out, {"this trajectory"});  // of which log it is, nobody said
  const Outcome quiet = done(judge(path("way.tum"), path("relations.txt"), {"--quiet"}));
  EXPECT_EQ(quiet.out + quiet.err, "");
}

// What `slam` says of its trajectory is what is said of the file that it wrote, but for the file's 6
// decimals.
TEST_F(RelationsProgram, SaysWhatSlamSays) {
  const SmallDrive drive = small_drive(small_room(), 20);
  write("drive.log", carmen_log_of(drive));
  std::string relations;
  for (std::size_t k = 5; k < drive.truth.size(); k += 5) {
    const Pose delta = relative(drive.truth[k].pose, drive.truth[k - 5].pose);
    relations += std::to_string(drive.truth[k - 5].stamp_s) + " " + std::to_string(drive.truth[k].stamp_s) +
                 " " + std::to_string(delta.x_m) + " " + std::to_string(delta.y_m) + " 0 0 0 " +
                 std::to_string(delta.theta_rad) + "\n";
  }
  write("drive.txt", relations);
  const Args slam{"slam",        "--log", path("drive.log"), "--relations", path("drive.txt"),
                  "--particles", "3",     "--out",           path("map"),   "--json"};
  const Json theirs = told(slam).at("relations");
  const Json ours = told(judge(path("map/trajectory.tum"), path("drive.txt"), {"--json"})).at("relations");
  EXPECT_EQ(ours.at("compared"), 3);
  ASSERT_EQ(ours.size(), theirs.size());
  for (const auto& [key, value] : ours.items())
    EXPECT_NEAR(value.get<double>(), theirs.at(key).get<double>(), 3e-6) << key;
}

TEST_F(RelationsProgram, ErrorsAreOneLineWithACode) {
  const std::string trajectory = path("way.tum"), relations = path("relations.txt");
  const Args both = judge(trajectory, relations);
  const auto files = [](const std::string& t, const std::string& r) { return judge(path(t), path(r)); };
  const ProgramCase cases[] = {
      {{"evaluate", "--relations", relations}, 2, "--trajectory T.tum"},
      {{"evaluate", "--trajectory", trajectory}, 2, "--relations R.txt"},
      {{"evaluate", "--dataset", "intel", "--log", kLog[1]}, 2, "--relations R.txt"},
      {with(both, {"--dataset", "atlantis"}), 2,
       "aces, intel, mit_killian, mit_csail, freiburg_079, freiburg_hospital, got 'atlantis'"},
      {with(both, {"--log", kLog[1]}), 2, "--log belongs to trials"},
      {with(both, {"--scenario", "s.yaml"}), 2, "--scenario belongs to trials"},
      {with(both, {"--map", kLog[3]}), 2, "--map belongs to trials"},
      {with(both, {"--samples", path("s.csv")}), 2, "--samples belongs to trials"},
      {with(both, {"--relations", ""}), 2, "--relations"},
      {with(both, {"--out", "/dev/null/x"}), 5, "/dev/null/x"},
      {files("missing.tum", "relations.txt"), 3, "missing.tum"},
      {files("way.tum", "missing.txt"), 3, "missing.txt"},
      {files("way.tum", "empty.txt"), 3, "empty.txt: expected a relation, found none"},
      {files("empty.tum", "relations.txt"), 3, "empty.tum: expected a pose, found none"},
      {files("way.tum", "junk.txt"), 3, "junk.txt:2: expected 8 numbers"},
      {files("way.tum", "nan.txt"), 3, "nan.txt:1: expected a finite translation"},
      {files("nan.tum", "relations.txt"), 3, "nan.tum:2: expected a finite position"},
      {files("junk.tum", "relations.txt"), 3, "junk.tum:1: expected 8 numbers"},
      {files("way.tum", "elsewhen.txt"), 3, "of 2, none has both its stamps there"},
  };
  for (const ProgramCase& c : cases) expect_error(call(c.args), c);
}

// What the data's README states about its own references, through the program.
TEST_F(RelationsProgram, PublishedTrajectories) {
  const struct {
    const char* log;
    double mean_m, std_m;
  } logs[] = {{"intel", 0.027, 0.020}, {"aces", 0.045, 0.040}};
  for (const auto& one : logs) {
    const std::string folder = real_data(one.log);
    PARLOC_NEEDS_FILE(folder + "/relations.txt");
    done(judge(folder + "/reference.tum", folder + "/relations.txt",
               {"--dataset", one.log, "--out", path(one.log)}));
    const Json e = json_of(std::string(one.log) + "/relations.json").at("relations");
    EXPECT_NEAR(e.at("translation_mean_m"), one.mean_m, 6e-4);  // half of the last digit given
    EXPECT_NEAR(e.at("translation_std_m"), one.std_m, 6e-4);
    EXPECT_EQ(e.at("without_pose"), 0);
  }
}

}  // namespace
}  // namespace parloc::test
