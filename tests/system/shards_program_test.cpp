// `--shard` and `parloc merge`: parts together are the whole, byte for byte but for what a clock says; what
// was killed goes on; what does not belong together is named.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

namespace fs = std::filesystem;

const Args kCorridorLog{"--log",   "maps/logs/malaga_corridor.log.gz", "--map", "maps/malaga_corridor.yaml",
                        "--truth", "maps/logs/malaga_corridor.tum"};
const Args kHall{"evaluate",    "--scenario", "configs/paz2012_scenario.yaml",
                 "--task",      "track",      "--trials",
                 "5",           "--duration", "2",
                 "--particles", "100",        "--quiet"};
// Said as they go on, one at a time.
const Args kNineSlowTrials{"evaluate",
                           "--scenario",
                           "configs/paz2012_scenario.yaml",
                           "--task",
                           "track",
                           "--trials",
                           "9",
                           "--duration",
                           "20",
                           "--particles",
                           "2000",
                           "--jobs",
                           "1"};

class ShardsProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() { open("parloc_shards_test"); }
  void SetUp() override { fs::remove_all(runner->folder() / "parts"); }

  static std::string part(std::size_t number) { return path("parts/" + std::to_string(number)); }
  static Args shard_of(const Args& command, std::size_t number, std::size_t of) {
    return with(command,
                {"--shard", std::to_string(number) + "/" + std::to_string(of), "--out", part(number)});
  }
  static Args merge_of(const std::vector<std::size_t>& numbers, const Args& more = {}) {
    Args args{"merge"};
    for (const std::size_t number : numbers) args.push_back(part(number));
    return with(args, with({"--quiet"}, more));
  }
  /// A page without its date and what stands below "Times" or in a row "times".
  static std::string untimed(std::string page) {
    page = page.substr(0, page.find("<h2>Times on this machine"));
    page = std::regex_replace(page, std::regex("[0-9-]+T[0-9:]+Z"), "DATE");
    page = std::regex_replace(
        page, std::regex("<div class=\"wide\"><table class=\"numbers\"><caption>Times.*?</table>"), "");
    return std::regex_replace(page, std::regex("<tr><th>times</th>.*?</tr>"), "");
  }
  static Json untimed_json(const std::string& file) {
    Json json = json_of(file);
    json.erase("times");
    return json;
  }
};

TEST_F(ShardsProgram, PartsTogetherAreTheWhole) {
  struct Case {
    Args command;
    const char* json;
    std::size_t parts;
  };
  const std::vector<Case> cases{
      {kHall, "evaluate.json", 7},  // two of them have nothing to do
      {with({"evaluate", "--starts", "4", "--duration", "10", "--particles", "200", "--quiet"}, kCorridorLog),
       "evaluate.json", 3},
      {{"evaluate", "--families", "--family", "corridor", "--trials", "3", "--particles", "100", "--quiet"},
       "families.json",
       2},
      {with({"evaluate", "--corrupt", "slips=3", "--trials", "3", "--particles", "200", "--quiet"},
            kCorridorLog),
       "families.json", 2},
      {{"compare", "--filters", "mcl@100,ekf", "--scenario", "configs/paz2012_scenario.yaml", "--seeds", "3",
        "--duration", "3", "--quiet"},
       "compare.json",
       2}};
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::PrintToString(c.command));
    SetUp();
    done(with(c.command, {"--out", path("whole")}));
    std::vector<std::size_t> numbers;
    for (std::size_t k = c.parts; k >= 1; --k) {  // in any order
      EXPECT_EQ(done(shard_of(c.command, k, c.parts)).out, "");
      numbers.push_back(k);
    }
    done(merge_of(numbers, {"--out", path("merged")}));
    const auto all = contents(path("whole"));
    ASSERT_EQ(contents(path("merged")).size(), all.size());
    for (const auto& [file, text] : all) {
      const std::string name = fs::path(file).filename().string();
      if (name == c.json) {
        EXPECT_EQ(untimed_json("merged/" + name).dump(), untimed_json("whole/" + name).dump());
      } else if (name == "report.html") {
        EXPECT_EQ(untimed(read("merged/" + name)), untimed(text));
      }
    }
    EXPECT_EQ(json_of("merged/" + std::string(c.json))["times"]["shards"], c.parts);
    fs::remove_all(path("whole")), fs::remove_all(path("merged"));
  }
}

TEST_F(ShardsProgram, SamplesAreKeptForWhoeverAskedForThem) {
  const Args command = with(kHall, {"--samples", path("all.csv")});
  done(command);
  const std::string whole = read("all.csv");
  EXPECT_GT(whole.size(), 1000u);
  fs::remove(path("all.csv"));
  done(shard_of(command, 1, 2)), done(shard_of(command, 2, 2));
  EXPECT_FALSE(fs::exists(path("all.csv")));
  done(merge_of({1, 2}));
  EXPECT_EQ(read("all.csv"), whole);
}

TEST_F(ShardsProgram, WhatWasKilledGoesOn) {
  const pid_t child = runner->start(shard_of(kNineSlowTrials, 1, 1));
  runner->wait_for(" 2 of 9 trials");
  kill(child, SIGKILL);
  EXPECT_EQ(runner->finish(child).code, -1);
  EXPECT_EQ(call(merge_of({1})).code, 3);  // unfinished
  const std::string file = part(1) + "/shard.parloc";
  const std::string before = content_of(file);
  write_file(file, before + "TIAL and some");  // as if it had been killed while it wrote
  const Outcome rest = done(shard_of(kNineSlowTrials, 1, 1));
  expect_parts(rest.out, {"9 of its 9 trials", "of them from before"});
  EXPECT_EQ(content_of(file).rfind(before, 0), 0u);
  expect_parts(done(shard_of(kNineSlowTrials, 1, 1)).out, {"9 of them from before"});  // nothing left to do
  const Json merged = told({"merge", part(1), "--json"});
  const Json whole = told(with(kNineSlowTrials, {"--quiet", "--json"}));
  EXPECT_EQ(merged["trials"], whole["trials"]);
  EXPECT_EQ(merged["summary"], whole["summary"]);
}

TEST_F(ShardsProgram, CtrlCKeepsWhatIsFinished) {
  const Outcome o = broken_off(shard_of(kNineSlowTrials, 1, 1), " 1 of 9 trials");
  EXPECT_EQ(o.out.find("9 of its 9"), std::string::npos) << o.out;
  expect_parts(o.out, {"of its 9 trials are in"});
}

TEST_F(ShardsProgram, WhatDoesNotBelongTogetherIsNamed) {
  for (const std::size_t k : {1, 2, 3}) done(shard_of(kHall, k, 3));
  const auto refused = [&](const Args& args, const std::string& words, int code = 3) {
    expect_one_line(call(args), code, words);
  };
  refused(merge_of({1, 3}), "expected all 3 shards, found 2: missing 2");
  refused(merge_of({1, 2, 3, 2}), "are the same shard, 2 of 3");
  refused(merge_of({1, 2, 4}), "cannot be read");
  refused({"merge"}, "DIRS", 2);

  fs::copy(part(2), part(4));
  done(with(shard_of(kHall, 2, 3), {"--jobs", "1"}));  // decides nothing
  Args other = kHall;
  other[6] = "6";  // --trials
  refused(with(other, {"--shard", "2/3", "--out", part(2)}), "holds results of another run");
  refused(with(kHall, {"--shard", "3/3", "--out", part(2)}), "holds results of another run: shard 2");
  done(with(other, {"--shard", "2/3", "--out", part(5)}));
  refused(merge_of({1, 5, 3}), "expected shards of one run");

  std::string bytes = content_of(part(4) + "/shard.parloc");
  bytes[bytes.size() - 40] ^= 1;
  write_file(part(4) + "/shard.parloc", bytes);
  refused(merge_of({1, 4, 3}), "damaged after 1 trials");
  write_file(part(4) + "/shard.parloc", "something else");
  refused(merge_of({1, 4, 3}), "expected the results of a shard");
  std::string run = content_of(part(1) + "/shard.parloc");
  run.replace(run.find("parloc evaluate"), 15,
              "parloc simulate");  // nothing else than to merge is done for it
  write_file(part(4) + "/shard.parloc", run);
  refused(merge_of({4}), "expected a shard of evaluate or compare, found one of 'parloc simulate");
  EXPECT_EQ(call(merge_of({1, 2, 3})).code, 0);  // these are as they were
}

TEST_F(ShardsProgram, CompareHasNoJsonToPrint) {
  done(shard_of({"compare", "--filters", "ekf", "--scenario", "configs/paz2012_scenario.yaml", "--seeds", "1",
                 "--duration", "1", "--quiet"},
                1, 1));
  expect_error(call(merge_of({1}, {"--json"})),
               {{}, 2, "--json: compare prints no JSON; expected --out DIR"});
}

TEST_F(ShardsProgram, AMapThatHasChangedIsToldAndNotMerged) {
  fs::copy("maps/malaga_corridor.yaml", path("m.yaml"));
  std::string yaml = read("m.yaml");
  yaml = std::regex_replace(yaml, std::regex("image: *"), "image: " + fs::absolute("maps").string() + "/");
  write("m.yaml", yaml);
  Args command =
      with({"evaluate", "--starts", "2", "--duration", "5", "--particles", "100", "--quiet"}, kCorridorLog);
  command[11] = path("m.yaml");
  done(shard_of(command, 1, 1));
  EXPECT_EQ(call(merge_of({1})).code, 0);
  write("m.yaml", std::regex_replace(yaml, std::regex("resolution: *[0-9.]+"), "resolution: 0.2"));
  expect_one_line(call(merge_of({1})), 3, "has read another map");
}

TEST_F(ShardsProgram, WrongOptionsAreSaidBeforeTheWork) {
  const auto refused = [&](const Args& more, const std::string& words, int code) {
    expect_one_line(call(with(kHall, more)), code, words);
  };
  for (const char* text : {"3", "0/3", "4/3", "a/3", "1/0", "1/3/5", "-1/3"})
    refused({"--shard", text, "--out", part(1)}, "--shard", 2);
  refused({"--shard", "1/2"}, "expected --out DIR as well", 2);
  refused({"--shard", "1/2", "--out", part(1), "--json"}, "neither --json nor --merged", 2);
  write("file", "");
  refused({"--shard", "1/2", "--out", path("file") + "/inside"}, "cannot be written", 5);
}

}  // namespace
}  // namespace parloc::test
