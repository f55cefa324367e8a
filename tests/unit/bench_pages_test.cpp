// `parloc bench`: numbers, tables, the pages and JSON that it writes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/expect.h"
#include "tools/bench/forms.h"
#include "tools/bench/plan.h"
#include "tools/bench/published.h"
#include "tools/bench/steps/variants.h"
#include "tools/report/text/numbers.h"
#include "tools/report/text/table.h"

namespace parloc::tools::bench {
namespace {

using Json = nlohmann::json;

TEST(Numbers, HaveFewDigits) {
  EXPECT_EQ(significant(0.00123456, 3), "0.00123");
  EXPECT_EQ(significant(0.0999, 2), "0.10");
  EXPECT_EQ(significant(123456.0, 3), "123000");
  EXPECT_EQ(significant(0.0, 3), "0");
  EXPECT_EQ(significant(NAN, 3), "-");
  EXPECT_EQ(seconds_text(0.76789), "0.7679");
  EXPECT_EQ(seconds_text(0.0012345), "0.00123");
  EXPECT_EQ(milliseconds_text(0.0012345), "1.23");
  EXPECT_EQ(short_number(68.93e6), "68.9 M");
  EXPECT_EQ(short_number(1.49e9), "1.49 G");
  EXPECT_EQ(grouped(16'777'216), "16,777,216");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(-1000), "-1,000");
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Tables, ArePartedWhereTheyAreTooWide) {
  Table table;
  table.title = "T";
  table.columns = {{"", "key", true}, {"a", "one"}, {"a", "two"}, {"b", "three"}, {"b", "four"}};
  table.rows = {{"x", "1", "2", "3", "4"}, {"y", "11", "22", "33", "44"}};
  const auto whole = lines_of(terminal_text(table, 100));
  ASSERT_EQ(whole.size(), 5u) << terminal_text(table, 100);
  EXPECT_EQ(whole[3], "x      1    2      3     4");
  const auto parts = lines_of(terminal_text(table, 16));
  ASSERT_EQ(parts.size(), 10u) << terminal_text(table, 16);  // title, 4, blank, 4
  for (const std::string& line : parts) EXPECT_LE(line.size(), 16u) << line;
  EXPECT_EQ(parts[3], "x      1    2");
  EXPECT_EQ(parts[8], "x        3     4");
  EXPECT_EQ(lines_of(markdown_text(table)).size(), 6u);
  table.rows[0][0] = "<script>";
  expect_none_of(html_text(table), {"<script>"});
}

TEST(Results, SkippedRowsOfOneReasonAreOneLine) {
  const auto lines = skipped_lines({{"a", "memory"}, {"b", "time"}, {"c", "memory"}});
  EXPECT_EQ(lines, (std::vector<std::string>{"skipped a and 1 more: memory", "skipped b: time"}));
}

/// Results as of a large machine, with made-up times: particles x beams / rate.
Results made_up(bool scale) {
  Results r;
  r.scale = scale;
  r.command = "parloc bench --out <b>";
  r.date = date_now();
  r.machine = machine_here();
  r.scenes = {{"no_hit", "empty"}};
  const Place place{"no_hit", "tracking"};
  const auto add = [&](Sweep sweep, std::size_t v, std::int64_t n, int m, double rays_per_s) {
    Row row{sweep, place, v, n, m, {}, {}};
    row.time = summarise_times({static_cast<double>(n) * m / rays_per_s});
    if (scale) row.stages = StageSeconds{1e-6, 1e-6, row.time.median_s, 1e-5, 1e-5, 1e-5};
    r.rows.push_back(row);
  };
  for (const Variant& v : {Variant{Algorithm::paz2012, BackendChoice::cpu, 1, 0},
                           {Algorithm::paz2012, BackendChoice::cpu, 128, 0},
                           {Algorithm::parloc, BackendChoice::cpu, 1, 0},
                           {Algorithm::parloc, BackendChoice::cpu, 128, 0},
                           {Algorithm::parloc, BackendChoice::cuda, 1, 0},
                           {Algorithm::parloc, BackendChoice::cuda, 1, 1}})
    r.index_of(v);
  double rays_per_s = 1e6;
  for (std::size_t v = 0; v < r.variants.size(); ++v, rays_per_s *= 7.0) {
    if (!scale) {
      for (const std::int64_t n : kPublishedParticles)
        for (const int m : kPublishedBeams) add(Sweep::tables, v, n, m, rays_per_s);
    } else {
      for (std::int64_t n = 1024; n <= 16'777'216; n *= 4) add(Sweep::particles, v, n, 200, rays_per_s);
      for (const int m : {50, 1080}) add(Sweep::beams, v, 65'536, m, rays_per_s);
      for (const std::int64_t n : {4000, 65'536}) add(Sweep::threads, v, n, 200, rays_per_s);
      for (const double budget_s : kScaleBudgets_s) {
        r.largest.push_back(
            {place, v, 200, budget_s, 16'777'216, 0, "the most that parloc takes", 0.01, 0.02});
        r.largest.push_back({place, v, 200, budget_s, 0, 64, "", 0.0, 0.0});
      }
    }
  }
  r.skipped = {
      {"no_hit, tracking, 16777216 x 200: parloc, 1 thread", "needs 2.5 GB of memory, 1 GB are available"}};
  r.notes = {"cuda 2 is not measured: no kernel image is available for execution on the device"};
  return r;
}

TEST(Pages, FitTheTerminal) {
  for (const bool scale : {false, true}) {
    Results results = made_up(scale);
    results.interrupted = true;
    const std::string page = terminal_page(results);
    for (const std::string& line : lines_of(page)) EXPECT_LE(line.size(), 100u) << line;
    expect_parts(page, {"skipped no_hit, tracking, 16777216 x 200", "no kernel image", "- interrupted"});
  }
}

// The rows of a peer are those of its model on as many threads; what was not measured is not there.
TEST(Pages, StandBesideOtherPrograms) {
  Results results = made_up(false);
  const Place place{"no_hit", "tracking"};
  EXPECT_TRUE(peers_table(results, place).rows.empty());
  Row row{Sweep::peers,
          place,
          results.index_of({Algorithm::parloc, BackendChoice::cpu, 2, 0, SensorModel::beam}),
          kPeerParticles,
          kPeerBeams,
          {},
          {}};
  row.time = summarise_times({0.0047});
  results.rows.push_back(row);
  const Table table = peers_table(results, place);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"beam", "Beluga", "2", "188", "4.70", "40.0 x"}));
  for (const std::string& line : lines_of(terminal_page(results))) EXPECT_LE(line.size(), 100u) << line;
  expect_parts(terminal_page(results), {"Beluga", "40.0 x"});
}

TEST(Pages, MarkWhatIsWithinTheBudgetAndGiveRatios) {
  const Results results = made_up(false);
  const Table table = published_table(results, {"no_hit", "tracking"}, published_tables()[1]);
  ASSERT_EQ(table.rows.size(), 15u);
  const auto& last = table.rows.back();
  EXPECT_EQ(last[0], "4000x200");
  EXPECT_EQ(last[1], "0.1642 ");
  EXPECT_EQ(last[2], "0.8000 ");  // 800,000 rays at 1 M/s
  EXPECT_EQ(last[3], "4.9");      // 0.8 / 0.1642
  EXPECT_EQ(last[6], "0.0163*");  // at 49 M/s
  const Table summary = summary_table(results, {"no_hit", "tracking"});
  ASSERT_EQ(summary.rows.size(), 9u);
  EXPECT_EQ(summary.rows[0][1], "1 of 15");
  EXPECT_EQ(summary.rows[2][1], "9 of 15");
  EXPECT_EQ(summary.rows[3][1], "1 of 15");  // 500 x 50 in 25 ms alone
  EXPECT_EQ(summary.rows[5].back(), "49.0 x");
}

TEST(Pages, WebPageIsWholeAndSafe) {
  for (const bool scale : {false, true}) {
    const std::string html = html_page(made_up(scale));
    expect_parts(html, {"</html>", "&lt;b&gt;", ">40 ms</span>"});
    expect_none_of(html, {"http", "src=", "nan"});  // nothing is fetched
    std::size_t figures = 0;
    for (std::size_t at = html.find("<figure"); at != std::string::npos; at = html.find("<figure", at + 1))
      ++figures;
    EXPECT_EQ(figures, 3u);
  }
}

TEST(Pages, JsonHasEverything) {
  const Json tables = Json::parse(json_text(made_up(false)));
  EXPECT_EQ(tables.at("mode"), "tables");
  EXPECT_EQ(tables.at("interrupted"), false);
  const auto expect_keys = [](const Json& json, std::initializer_list<const char*> keys) {
    for (const char* key : keys) EXPECT_TRUE(json.contains(key)) << key;
  };
  expect_keys(tables.at("machine"),
              {"cpu", "cores", "memory_bytes", "os", "devices", "gpu_driver", "load_average", "settings"});
  expect_keys(tables.at("build"), {"version", "commit", "compiler", "flags", "build_type", "cuda"});
  expect_keys(tables,
              {"command", "date", "protocol", "scenes", "published", "variants", "rows", "skipped", "notes"});
  ASSERT_EQ(tables.at("rows").size(), 90u);
  const Json& row = tables.at("rows").at(14);
  for (const char* key : {"median_s", "p99_s", "q1_s", "q3_s", "steps", "rays_per_s", "particles", "beams"})
    EXPECT_TRUE(row.at(key).is_number()) << key;
  EXPECT_EQ(row.at("variant"), "paz2012, 1 thread");
  EXPECT_NEAR(row.at("ratio").at("gtx560").get<double>(), 0.8 / 0.1642, 1e-9);
  EXPECT_EQ(row.at("within_budget"), false);
  EXPECT_EQ(tables.at("published").at(2).at("seconds").at(4).at(2), 0.0975);
  EXPECT_EQ(tables.at("variants").at(0).at("caster"), "fixed_step");
  EXPECT_EQ(tables.at("variants").at(0).at("resampling"), "multinomial_linear");
  EXPECT_EQ(tables.at("variants").at(4).at("backend"), "cuda");

  const Json scale = Json::parse(json_text(made_up(true)));
  EXPECT_EQ(scale.at("mode"), "scale");
  const Json& weight = scale.at("rows").at(0).at("stages").at("weight");
  EXPECT_GT(weight.at("share").get<double>(), 0.9);
  EXPECT_DOUBLE_EQ(weight.at("least_bytes").get<double>(), 20.0 * 1024);  // pose, and log-weight twice
  EXPECT_TRUE(weight.at("least_bytes_per_s").is_number());
  EXPECT_EQ(scale.at("largest").at(0).at("particles"), 16'777'216);
  EXPECT_EQ(scale.at("largest").at(1).at("too_many"), 64);
}

}  // namespace
}  // namespace parloc::tools::bench
