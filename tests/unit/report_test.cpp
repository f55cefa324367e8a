// Reports: what every HTML file must hold, whatever the run looked like.
#include "tools/report/report.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <regex>

#include "tests/unit/decoded_png.h"
#include "tests/unit/expect.h"
#include "tests/unit/sample_report.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The part of the hall up to a column, as if no more were known yet, on a grid of its own of cells of 10 cm.
MapMoment half_known(const GridMap& hall, const RunReport& report, int columns) {
  MapMoment moment;
  GridMap& map = moment.map;
  map.width = columns / 2, map.height = hall.height / 2, map.resolution_m = 2 * hall.resolution_m;
  map.T_map_grid = hall.T_map_grid;
  for (int j = 0; j < map.height; ++j)
    for (int i = 0; i < map.width; ++i) map.cells.push_back(hall.at(2 * i, 2 * j));
  moment.state = report.snapshots.front();
  moment.state.stamp_s += columns;
  moment.path = report.estimate;
  moment.facts = {{"scans taken in", std::to_string(columns)}, {"<odd>", "&"}};
  return moment;
}

/// The page without what follows `begin` up to the end of the attribute.
std::string cut_after(const std::string& html, const std::string& begin) {
  std::string out;
  std::size_t at = 0;
  for (std::size_t cut = html.find(begin); cut != std::string::npos; cut = html.find(begin, at)) {
    cut += begin.size();
    out += html.substr(at, cut - at);
    at = html.find('"', cut);
  }
  return out + html.substr(at);
}

/// The first tag that is not closed in order, or an empty string.
std::string first_unbalanced_tag(const std::string& html) {
  std::vector<std::string> open;
  const std::regex tag("<(/?)([a-zA-Z][a-zA-Z0-9]*)((?:[^<>\"]|\"[^\"]*\")*)>");
  for (auto it = std::sregex_iterator(html.begin(), html.end(), tag); it != std::sregex_iterator(); ++it) {
    const std::string name = (*it)[2], rest = (*it)[3];
    if ((*it)[1].length() > 0) {
      if (open.empty() || open.back() != name) return "</" + name + ">";
      open.pop_back();
    } else if (rest.empty() || rest.back() != '/') {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : "<" + open.back() + ">";
}

void expect_well_formed(const std::string& html) {
  const std::string page = cut_after(html, "base64,");            // images' data may spell anything
  EXPECT_EQ(first_unbalanced_tag(cut_after(page, " d=\"")), "");  // std::regex recurses per character
  expect_none_of(page, {"http:", "https:", "src=", "@import", "<link", "//cdn"});  // nothing from outside
  expect_none_of(page, {"nan", "NaN", "inf ", "inf\"", "inf%", "Infinity"});
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST_F(ReportTest, HoldsEveryPart) {
  const std::string page = html(sample(&map_, 600));
  expect_well_formed(page);
  expect_parts(page,
               {"ellipse.log.gz on hall.yaml", "Real-time factor", "RMSE 1.23 cm", "Position error",
                "Error in x", "Error in y", "Error in heading", "Effective particles", "threshold",
                "Standard deviation of position", "Time per step", "likelihood_field", "parloc run --map",
                "id=\"cloud7\"", "prefers-color-scheme:dark", "width=device-width"});
  EXPECT_EQ(count(page, "data:image/png;base64,iVBORw0KGgo"), 1U);  // the PNG signature in base 64
  EXPECT_EQ(count(page, "class=\"snap\""), 8U);
  EXPECT_EQ(count(page, "<figure class=\"plot\">"), 8U);
}

TEST_F(ReportTest, SameReportSameBytes) {
  EXPECT_EQ(html(sample(&map_, 300), "a.html"), html(sample(&map_, 300), "b.html"));
}

TEST_F(ReportTest, LongRunsStaySmall) {
  RunReport report = sample(&map_, 15000);
  while (report.snapshots.size() < 60) report.snapshots.push_back(report.snapshots.back());
  report.snapshots[0].particles.resize(100000, {1, 1, 0, 1});
  const std::string page = html(report, "long.html");
  expect_well_formed(page);
  EXPECT_LT(page.size(), 3'000'000U);
  EXPECT_EQ(count(page, "class=\"snap\""), 24U);
}

TEST_F(ReportTest, ShowsAMapInTheMaking) {
  RunReport report = sample(&map_, 600);
  for (int k = 0; k < 40; ++k) report.growth.push_back(half_known(map_, report, 20 + 10 * k));
  report.growth_note = "a note <of> mine";
  report.plots = {{"Another plot", "MiB", PlotScale::linear, {{"", "c1", {1e9, 1e9 + 9}, {1, 2}}}}};
  const std::string page = html(report, "growth.html");
  expect_well_formed(page);
  expect_parts(
      page, {"How the map grew", "id=\"grow\"", "max=\"23\"", "id=\"play\"", "a note &lt;of&gt; mine",
             "&lt;odd&gt;", "scans taken in", "<dd>410</dd>", "id=\"grown23\"", "#grown23", "Another plot"});
  EXPECT_EQ(count(page, "data:image/png;base64,iVBORw0KGgo"), 25U);  // 24 moments and the whole map
  EXPECT_EQ(count(page, "<g class=\"grown\""), 24U);
  EXPECT_EQ(count(page, "<dl class=\"told\">"), 1U);  // of the last moment; the others wait for the script
  EXPECT_EQ(count(page, "<dl class=\"told\" style=\"display:none\">"), 23U);
  EXPECT_LT(page.size(), 1'500'000U);
  expect_none_of(html(sample(&map_, 600), "no_growth.html"), {"How the map grew", "id=\"grow"});
}

// Whatever the moment's grid: its cells lie where they are on the whole map, which is drawn in the same
// figure.
TEST_F(ReportTest, AMapInTheMakingLiesInItsPlace) {
  RunReport report = sample(&map_, 600);
  report.growth.push_back(half_known(map_, report, 420));
  const std::string page = html(report, "place.html");
  const std::regex image(
      "<image class=\"cells\" x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" width=\"([0-9.]+)\" height=\"([0-9.]+)\" "
      "preserveAspectRatio=\"none\" href=\"");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(page, found, image));
  const std::size_t figure = page.find("viewBox=\"0 0 ", page.find("How the map grew"));
  double width = 0, height = 0;
  ASSERT_EQ(std::sscanf(page.c_str() + figure, "viewBox=\"0 0 %lf %lf", &width, &height), 2);
  // The figure's pixels are cells of 5 cm; the moment's cells of 10 cm begin at most one earlier and end at
  // most one later than the figure.
  EXPECT_NEAR(std::stod(found[1]), 0.0, 2.0);
  EXPECT_NEAR(std::stod(found[2]) + std::stod(found[4]), height, 2.0);
  EXPECT_NEAR(std::stod(found[3]), width, 4.0);
  EXPECT_NEAR(std::stod(found[4]), height, 4.0);
}

TEST_F(ReportTest, EscapesAllText) {
  const std::string evil = "<script>alert(\"x\")</script> & 'quoted' \x01 \xFF";
  RunReport report = sample(&map_, 50);
  report.title = report.command_line = evil;
  report.summary = {{evil, evil}};
  report.details = {{evil, {{evil, evil}}}};
  report.warnings = {evil};
  const std::string page = html(report, "evil.html");
  expect_well_formed(page);
  expect_none_of(page, {"<script>alert", "\x01", "\xFF"});
  EXPECT_EQ(count(page, "<script>"), 1U);  // parloc's own
  EXPECT_EQ(escape_html("a<b>\"&'\xC3\xA9"), "a&lt;b&gt;&quot;&amp;&#39;\xC3\xA9");
  EXPECT_EQ(escape_html("\xC0\xAF\xED\xA0\x80"),
            "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST_F(ReportTest, WorksWithoutTruth) {
  RunReport report = sample(&map_, 200);
  report.truth.reset();
  report.errors.reset();
  const std::string page = html(report, "no_truth.html");
  expect_well_formed(page);
  expect_none_of(page, {"Position error", "truth c2"});
  expect_parts(page, {"Effective particles"});
  write_picture(in_folder("no_truth.png"), report);
  EXPECT_THROW(write_error_picture(in_folder("no_errors.png"), report), Error);
  EXPECT_FALSE(std::filesystem::exists(in_folder("no_errors.png")));
}

TEST_F(ReportTest, WorksWithoutAnything) {
  RunReport report;
  report.title = "empty";
  expect_well_formed(html(report, "empty.html"));
  EXPECT_THROW(write_picture(in_folder("empty.png"), report), Error);
  EXPECT_FALSE(std::filesystem::exists(in_folder("empty.png")));
  report.estimate = {{0, {1, 2, 0}}};  // a single pose, no map
  expect_well_formed(html(report, "one_pose.html"));
  write_picture(in_folder("one_pose.png"), report);
  report = {};
  report.title = "map only";
  report.map = &map_;
  expect_well_formed(html(report, "map_only.html"));
  write_picture(in_folder("map_only.png"), report);
}

TEST_F(ReportTest, ValuesThatAreNotFiniteLeaveGaps) {
  RunReport report = sample(&map_, 300);
  for (const double bad : {nan, infinity, -infinity, 1e300}) {
    const auto k = static_cast<std::size_t>(std::isnan(bad) ? 10 : bad > 1e299 ? 20 : 30);
    report.steps[k] = {bad, bad, bad, bad, bad, bad, true, true};
    report.steps[k + 1].n_eff = report.steps[k + 1].sigma_x_m = report.steps[k + 1].step_ms = bad;
    report.estimate[k] = {bad, {bad, bad, bad}};
    (*report.truth)[k] = {bad, {bad, bad, bad}};
    report.odometry[k].pose.x_m = bad;
    report.errors->x_error_m[k] = report.errors->heading_error_rad[k] = report.errors->position_error_m[k] =
        bad;
    report.errors->stamp_s[k + 1] = bad;
    const auto f = static_cast<float>(bad);
    report.snapshots[k / 10].particles[3] = {f, f, f, f};
    report.snapshots[k / 10].scan_points[3] = {f, f};
    report.snapshots[k / 10 + 1].pose = {bad, bad, bad};
    report.snapshots[k / 10 + 1].stamp_s = bad;
  }
  report.errors->position_rmse_m = nan;
  report.resample_below = infinity;
  expect_well_formed(html(report, "gaps.html"));
  write_picture(in_folder("gaps.png"), report);
  write_error_picture(in_folder("gaps_errors.png"), report);
  report.estimate.assign(5, {nan, {nan, nan, nan}});
  report.truth->clear();
  expect_well_formed(html(report, "all_gaps.html"));
  report.map = nullptr;
  report.odometry.clear();
  expect_well_formed(html(report, "nothing_left.html"));
}

TEST_F(ReportTest, UnwritablePathIsAnOutputError) {
  const RunReport report = sample(&map_, 20);
  const auto expect_error = [&](auto write, const std::string& path) {
    expect_parts(error_of([&] { write(path, report); }, ErrorKind::output), {path});
  };
  expect_error(write_report, in_folder("no/such/folder/r.html"));
  expect_error(write_picture, in_folder("no/such/folder/r.png"));
  std::filesystem::create_directories(in_folder("taken/inside"));
  expect_error(write_report, in_folder("taken"));  // a folder that is not empty
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    expect_none_of(entry.path().string(), {".part"});  // nothing is left behind
}

TEST_F(ReportTest, EveryCloudIsShownWhenAsked) {
  RunReport report = sample(&map_, 600);
  for (const bool every_cloud : {false, true}) {
    report.every_cloud = every_cloud;
    const std::string page = html(report, "clouds.html");
    expect_well_formed(page);
    EXPECT_EQ(count(page, "<g class=\"trail\">"), every_cloud ? 1U : 0U);
    // Close-ups have a class before href.
    EXPECT_EQ(count(page, "<use href=\"#cloud"), every_cloud ? 8U : 0U);
    write_picture(in_folder("clouds.png"), report);
    const Picture picture = decode(test::content_of(in_folder("clouds.png")));
    std::size_t green = 0;
    for (std::size_t k = 0; k + 2 < picture.rgb.size(); k += 3)
      green +=
          picture.rgb[k + 1] > picture.rgb[k] + 40 && picture.rgb[k + 1] > picture.rgb[k + 2] + 10 ? 1 : 0;
    // The first cloud is 1.5 m wide; the last one lies under the mark of the end, most of it.
    if (every_cloud)
      EXPECT_GT(green, 3000U);
    else
      EXPECT_LT(green, 1500U);
  }
}

TEST_F(ReportTest, RefusesAMapThatDoesNotFitItsCells) {
  map_.cells.pop_back();
  EXPECT_THROW(html(sample(&map_, 20), "bad_map.html"), Error);
}

}  // namespace
}  // namespace parloc::tools
