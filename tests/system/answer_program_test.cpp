// `parloc evaluate --bar` and `--against`: it stops where the answer is known, at the same trial for any
// number of jobs, says what is missing if it is not, and how long more trials take.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

class AnswerProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_answer_test");
    write("bare.yaml", "particles: 100\nlocalize:\n  recover: false\n");
    write("few.yaml", "particles: 99\n");
  }
  /// Told where it is, the filter is right; put elsewhere, one that does not search stays wrong.
  static Args trials(const std::string& task, const std::string& number, const Args& more) {
    return with({"evaluate", "--scenario", "configs/paz2012_scenario.yaml", "--task", task, "--trials",
                 number, "--duration", "2", "--particles", "100"},
                more);
  }
  static Json result(const std::string& folder) { return json_of(folder + "/evaluate.json"); }
  /// The result with 1 and with 3 jobs, which must be the same.
  static Json for_any_jobs(const Args& args) {
    done(with(args, {"--jobs", "1", "--quiet", "--out", path("one")}));
    done(with(args, {"--jobs", "3", "--quiet", "--out", path("three")}));
    EXPECT_EQ(lasting(result("one")), lasting(result("three")));
    EXPECT_TRUE(result("one")["times"].contains("dropped"));
    return result("three");
  }
};

// All of them come true: 8 trials decide about one half, 93 about 95 % (rate_sequence_test).
TEST_F(AnswerProgram, ABarThatIsReached) {
  const Json j = for_any_jobs(trials("track", "60", {"--bar", "0.5"}));
  EXPECT_EQ(j["answer"]["answer"], "reached");
  EXPECT_EQ(j["answer"]["trials"], 8);
  EXPECT_EQ(j["answer"]["hits"], 8);
  EXPECT_GT(j["answer"]["interval"][0], 0.5);
  EXPECT_EQ(j["answer"]["interval"][1], 1.0);
  EXPECT_TRUE(j["answer"]["more_trials"].is_null());
  EXPECT_EQ(j["trials"].size(), 8u);
  EXPECT_EQ(j["summary"]["success"]["of"], 8);
  EXPECT_FALSE(j["interrupted"]);
  EXPECT_GT(j["times"]["trial_s"], 0.0);
  expect_parts(read("three/report.html"), {"reached after 8 of at most 60 trials: success is more than 50 %",
                                           "Times of more trials", "1,000,000", "64 cores", "1000 more"});
}

TEST_F(AnswerProgram, ABarThatIsMissed) {
  const Json j = for_any_jobs(trials("kidnap", "60", {"--config", path("bare.yaml"), "--bar", "0.95"}));
  EXPECT_EQ(j["answer"]["answer"], "missed");
  EXPECT_LT(j["answer"]["trials"], 10);
  EXPECT_LT(j["answer"]["interval"][1], 0.95);
  EXPECT_EQ(j["answer"]["trials"], j["trials"].size());
}

TEST_F(AnswerProgram, ABarThatIsNotDecided) {
  const Outcome o = done(trials("track", "5", {"--bar", "0.95", "--out", path("open")}));
  expect_parts(o.out, {"not decided after 5 of at most 5 trials: whether success is 95 % or more",
                       "about 88 more would decide", "\n88 more "});
  const Json j = result("open");
  EXPECT_EQ(j["answer"]["answer"], "open");
  EXPECT_EQ(j["answer"]["more_trials"], 88);
  EXPECT_FALSE(j["interrupted"]);
  // Less sure, less to do.
  done(trials("track", "5", {"--bar", "0.95", "--error", "0.2", "--out", path("open")}));
  EXPECT_LT(result("open")["answer"]["more_trials"], 88);
}

TEST_F(AnswerProgram, AnotherConfigurationIsWorse) {
  const Json j = for_any_jobs(trials("kidnap", "60", {"--against", path("bare.yaml"), "--limit", "2"}));
  const Json& answer = j["answer"];
  EXPECT_EQ(answer["answer"], "worse");
  EXPECT_EQ(answer["only_other"].size(), 0u);
  EXPECT_EQ(answer["only_here"].size(), 8u);
  EXPECT_EQ(answer["pairs"], j["trials"].size());
  EXPECT_LT(answer["difference"][0], answer["difference"][1]);
  EXPECT_EQ(answer["hits"].get<int>() - answer["hits_other"].get<int>(), 8);
  // It is the same as each alone.
  const std::string pairs = std::to_string(answer["pairs"].get<int>());
  done(trials("kidnap", pairs, {"--limit", "2", "--quiet", "--out", path("here")}));
  EXPECT_EQ(result("here")["trials"], j["trials"]);
  done(trials("kidnap", pairs,
              {"--limit", "2", "--quiet", "--config", path("bare.yaml"), "--out", path("there")}));
  EXPECT_EQ(result("there")["summary"]["success"]["hits"], answer["hits_other"]);
}

TEST_F(AnswerProgram, AnotherConfigurationIsAsGood) {
  const Outcome o = done(trials("track", "6", {"--against", path("few.yaml"), "--out", path("same")}));
  expect_parts(o.out, {"no difference in success shown after 6 of at most 6 pairs: more than ",
                       "no number would: they look equally good"});
  const Json answer = result("same")["answer"];
  EXPECT_EQ(answer["answer"], "open");
  EXPECT_EQ(answer["error_smaller"]["smaller"].get<int>() + answer["error_smaller"]["larger"].get<int>(), 6);
}

// The starts of a log are in the order of its places: the first ones alone would say nothing about the rest.
TEST_F(AnswerProgram, StartsOfALogAreTakenHereAndThere) {
  const Args starts = with({"evaluate", "--task", "track", "--starts", "40", "--duration", "2", "--particles",
                            "200", "--bar", "0.5"},
                           kLog);
  const Json j = for_any_jobs(starts);
  ASSERT_NE(j["answer"]["answer"], "open");
  std::vector<int> seeds;
  for (const Json& trial : j["trials"]) seeds.push_back(trial["seed"]);
  EXPECT_TRUE(std::is_sorted(seeds.begin(), seeds.end()));
  EXPECT_EQ(seeds.size(), j["answer"]["trials"]);
  EXPECT_GT(seeds.back(), 20);
}

TEST_F(AnswerProgram, CtrlCAnswersByWhatIsThere) {
  const Args args =
      with(trials("track", "300", {"--bar", "0.9999", "--jobs", "2"}), {"--out", path("broken")});
  broken_off(args, "of at most 300 trials");
  const Json j = result("broken");
  EXPECT_TRUE(j["interrupted"]);
  EXPECT_EQ(j["answer"]["answer"], "open");
  EXPECT_EQ(j["answer"]["trials"], j["trials"].size());
  for (std::size_t k = 0; k < j["trials"].size(); ++k) EXPECT_EQ(j["trials"][k]["seed"], k + 1);
}

TEST_F(AnswerProgram, ErrorsAreOneLineWithACode) {
  const ProgramCase cases[] = {
      {{"--bar", "1"}, 2, "--bar: expected a number from 0.0001 to 0.9999, got '1'"},
      {{"--bar", "95%"}, 2, "--bar"},
      {{"--bar", "nan"}, 2, "--bar"},
      {{"--error", "0.05"}, 2, "--error: expected --bar or --against"},
      {{"--bar", "0.9", "--error", "0"}, 2, "--error: expected a number from 1e-06 to 0.5"},
      {{"--bar", "0.9", "--against", path("few.yaml")}, 2, "not both"},
      {{"--against", path("missing.yaml")}, 4, "missing.yaml"},
      {{"--bar", "0.9", "--shard", "1/2", "--out", path("part")}, 2, "--shard: a part does not see"},
      {{"--against", path("few.yaml"), "--shard", "1/2", "--out", path("part")}, 2, "--shard: a part"},
  };
  for (const ProgramCase& c : cases) expect_error(call(trials("track", "5", c.args)), c);
  const ProgramCase elsewhere[] = {
      {{"--families", "--bar", "0.9"}, 2, "not to --families"},
      {{"--relations", "R.txt", "--trajectory", "T.tum", "--bar", "0.9"}, 2, "--bar belongs to trials"},
  };
  for (const ProgramCase& c : elsewhere) expect_error(call(with({"evaluate"}, c.args)), c);
}

}  // namespace
}  // namespace parloc::test
