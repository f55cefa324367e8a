// Maps and scans with next to nothing in them, through the whole program: one clear line and a documented
// exit code, or `lost`; files without a number that is none.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>

#include "common/io/log.h"
#include "common/map/map_reader.h"
#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

const float kNan = std::nanf("");

/// Maps: what is free ('.'), a wall ('#') or unknown ('?'). `lone`: fine, and less than half of any 5 cm is
/// free.
struct NamedMap {
  const char* name;
  std::vector<std::string> rows;
  double resolution_m;
  bool has_free_cell;
};
std::vector<NamedMap> maps() {
  std::vector<std::string> lone(12, std::string(12, '?'));
  lone[5][5] = '.';
  return {{"wall", {"#"}, 0.05, false},
          {"unknown", std::vector<std::string>(40, std::string(40, '?')), 0.05, false},
          {"cell", {"."}, 0.05, true},
          {"two", {"..", ".."}, 0.05, true},
          {"corner", {"#..", "...", "..."}, 0.05, true},
          {"block", std::vector<std::string>(6, "......"), 0.05, true},
          {"row", {std::string(300, '.')}, 0.05, true},
          {"lone", lone, 0.01, true}};
}

/// The ranges of one scan [m], of a LiDAR that reaches 8 m. None of them tells of a place on any of the maps.
struct NamedScan {
  const char* name;
  std::vector<float> ranges_m;
  bool has_enough_beams;  ///< To be weighed.
};
std::vector<NamedScan> scans() {
  std::vector<float> lone(180, kNan);
  lone[90] = 0.5f;
  return {{"nan", std::vector<float>(180, kNan), false},
          {"zero", std::vector<float>(180, 0.0f), false},
          {"most", std::vector<float>(180, 8.0f), true},
          {"infinite", std::vector<float>(180, INFINITY), true},
          {"lone", lone, false},
          {"single", {0.5f}, false},
          {"far", std::vector<float>(180, 6.0f), true}};
}

std::string scan_yaml(const std::vector<float>& ranges_m) {
  std::string text = "angle_min_deg: -90\nangle_step_deg: 1\nrange_max: 8\nranges: [";
  for (const float r : ranges_m)
    text += std::isnan(r) ? ".nan, " : std::isinf(r) ? ".inf, " : std::to_string(r) + ", ";
  text.resize(text.size() - 2);
  return text + "]\n";
}

/// The same scan five times, a second in all, from a robot that stands still.
std::string still_log(const std::vector<float>& ranges_m) {
  std::string text;
  for (int k = 0; k < 6; ++k) {
    text += "FLASER " + std::to_string(ranges_m.size());
    for (const float r : ranges_m) text += ' ' + std::to_string(r);
    const std::string stamp = std::to_string(0.2 * k);
    text += " 1 1 0 1 1 0 " + stamp + " robot " + stamp + "\n";
  }
  return text;
}

class DegenerateProgram : public ProgramSuite {
 protected:
  static void SetUpTestSuite() {
    open("parloc_degenerate_test");
    for (const NamedMap& m : maps()) write_map(path_of(m), grid_from_text(m.rows, m.resolution_m));
    for (const NamedScan& s : scans()) {
      write(std::string(s.name) + "_scan.yaml", scan_yaml(s.ranges_m));
      write(std::string(s.name) + ".log", still_log(s.ranges_m));
    }
    write("truth.tum", "0 0.02 0.02 0 0 0 0 1\n1 0.02 0.02 0 0 0 0 1\n");
  }
  static std::string path_of(const NamedMap& m) { return path(std::string(m.name) + "_map.yaml"); }
};

/// Words are separated by anything but letters and digits.
bool has_word(const std::string& text, const std::string& word) {
  const auto in_word = [&](std::size_t at) { return at < text.size() && std::isalnum(text[at]) != 0; };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    if ((at == 0 || !in_word(at - 1)) && !in_word(at + word.size())) return true;
  return false;
}
void expect_numbers(const std::string& text) {
  EXPECT_FALSE(text.empty());
  EXPECT_FALSE(has_word(text, "nan") || has_word(text, "inf")) << text;
}

TEST_F(DegenerateProgram, LocateFindsNoPlaceOrSaysWhatIsWrong) {
  for (const NamedMap& m : maps()) {
    for (const NamedScan& s : scans()) {
      SCOPED_TRACE(std::string(m.name) + " map, " + s.name + " scan");
      const Outcome o =
          call({"locate", "--map", path_of(m), "--scan", path(std::string(s.name) + "_scan.yaml"),
                "--backend", "cpu", "--out", path("found")});
      if (!m.has_free_cell) {
        expect_one_line(o, 3, "no free cell");
        continue;
      }
      EXPECT_EQ(o.code, 7) << o.err;
      EXPECT_EQ(o.err, "");
      EXPECT_TRUE(json_of("found/hypotheses.json")["hypotheses"].empty());
    }
  }
}

// Also where a start pose is given: it may be wrong, and then the map is searched. Beams that return from
// nowhere do tell of a place where a map ends: not in its corner.
TEST_F(DegenerateProgram, RunIsLostOrSaysWhatIsWrong) {
  for (const NamedMap& m : maps()) {
    for (const NamedScan& s : scans()) {
      for (const std::string init : {"global", "0.01,0.01,0"}) {
        SCOPED_TRACE(std::string(m.name) + " map, " + s.name + " scan, from " + init);
        const Outcome o =
            call({"run", "--map", path_of(m), "--log", path(std::string(s.name) + ".log"), "--init", init,
                  "--particles", "100", "--backend", "cpu", "--quiet", "--out", path("out")});
        if (!m.has_free_cell) {
          expect_one_line(o, 3, "no free cell");
          continue;
        }
        if (init == "global") expect_one_line(o, 0, " at the end: ");
        if (!s.has_enough_beams) expect_one_line(o, 0, "parloc: LOST at the end: ");
        EXPECT_EQ(o.code, 0) << o.err;
        EXPECT_TRUE(Json::accept(read("out/metrics.json")));
        expect_numbers(read("out/trajectory.tum"));
      }
    }
  }
}

TEST_F(DegenerateProgram, EvaluateCountsNoSuccessOrSaysWhatIsWrong) {
  for (const NamedMap& m : maps()) {
    for (const char* log : {"nan.log", "most.log"}) {
      SCOPED_TRACE(std::string(m.name) + " map, " + log);
      const Outcome o =
          call({"evaluate", "--map", path_of(m), "--log", path(log), "--truth", path("truth.tum"), "--starts",
                "2", "--particles", "100", "--quiet", "--out", path("all"), "--samples", path("all.csv")});
      if (!m.has_free_cell) {
        expect_one_line(o, 3, "no free cell");
        continue;
      }
      EXPECT_EQ(o.code, 0) << o.err;
      EXPECT_EQ(json_of("all/evaluate.json")["summary"]["confident_wrong"]["hits"], 0);
      expect_numbers(read("all.csv"));
    }
    // A simulated drive needs room for a robot, on none of these.
    write("way.yaml", "speed: 0.5\npoints: [[0.01, 0.01], [0.02, 0.01]]\n");
    write("scenario.yaml",
          "map: " + std::string(m.name) + "_map.yaml\npath: way.yaml\nlocalization_map: cell_map.yaml\n");
    const Outcome o = call({"evaluate", "--scenario", path("scenario.yaml"), "--trials", "2", "--quiet"});
    expect_one_line(o, 3, "no free region");
  }
}

// A disc of radius 0 holds a cell if it is the cell's centre; a heading within 0 is one heading, or two on
// either side of it.
TEST_F(DegenerateProgram, PriorsWithoutWidth) {
  const Args locate{"locate",    "--map", "maps/hall_obstacles.yaml", "--scan", path("far_scan.yaml"),
                    "--backend", "cpu"};
  expect_one_line(call(with(locate, {"--near", "8.5,4.0,0"})), 3, "no free cell");  // a corner of four cells
  expect_one_line(call(with(locate, {"--near", "0.025,0.025,0"})), 3, "no free cell");  // in a wall
  for (const Args& prior : {Args{"--near", "8.525,4.025,0"}, Args{"--heading", "0.3,0"},
                            Args{"--near", "8.525,4.025,0", "--heading", "3.1415926535897932,0"}}) {
    const Outcome o = call(with(locate, prior));
    EXPECT_TRUE(o.code == 0 || o.code == 7) << o.err;
    EXPECT_EQ(o.err, "");
  }
}

}  // namespace
}  // namespace parloc::test
