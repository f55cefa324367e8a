// The YAML file of a map: what it says, what is read over, and one clear line per mistake.
#include "common/map/map_yaml.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/expect.h"

namespace parloc {
namespace {

std::string yaml_with(const std::string& mode_and_negate, const std::string& image = "map.pgm",
                      const std::string& origin = "[-1.5, 2, 0]") {
  return "image: " + image + "\nresolution: 0.05\norigin: " + origin +
         "\noccupied_thresh: 0.65\nfree_thresh: 0.196\n" + mode_and_negate;
}

TEST(MapYaml, ReadsEveryKey) {
  const MapYaml y = map_yaml_from_text(
      "# a map\nresolution: 0.050000\nimage: \"my map.pgm\"\norigin: [-27.2224, +48.5, -4.71238898038469]\n"
      "negate: 1\noccupied_thresh: .65\nfree_thresh: 0.196\nmode: scale\n",
      "m.yaml");
  EXPECT_EQ(y.image, "my map.pgm");
  EXPECT_EQ(y.image_line, 3u);
  EXPECT_EQ(y.resolution_m, 0.05);
  expect_near(y.T_map_grid, {-27.2224, 48.5, 1.5707963267948966}, 0.0, 1e-15);  // wrapped, not resampled
  EXPECT_TRUE(y.negate);
  EXPECT_EQ(y.occupied_thresh, 0.65);
  EXPECT_EQ(y.free_thresh, 0.196);
  EXPECT_EQ(y.mode, MapMode::scale);
}

TEST(MapYaml, ModeIsTrinaryUnlessSaid) {
  EXPECT_EQ(map_yaml_from_text(yaml_with("negate: 0"), "m").mode, MapMode::trinary);
  EXPECT_EQ(map_yaml_from_text(yaml_with("negate: false\nmode: raw"), "m").mode, MapMode::raw);
}

struct Mistake {
  std::string yaml;
  const char* message;
};

TEST(MapYaml, EachMistakeHasOneClearLine) {
  const std::string rest = "origin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  const std::string all = "image: a.pgm\nresolution: 0.05\n" + rest;
  const auto without = [&](const std::string& key) {
    std::string text = all;
    const std::size_t line = text.find(key + ':');
    return text.erase(line, text.find('\n', line) + 1 - line);
  };
  // The line of the same key is gone, so that it is the sixth and last.
  const auto with = [&](const std::string& line) {
    return without(line.substr(0, line.find(':'))) + line + '\n';
  };
  const std::vector<Mistake> mistakes{
      // Keys.
      {all + "ocupied_thresh: 1\n",
       "m.yaml:7: unknown key 'ocupied_thresh'; the nearest valid key is 'occupied_thresh'"},
      {without("resolution") + "resolutoin: 0.05\n",
       "m.yaml:6: unknown key 'resolutoin'; the nearest valid key is 'resolution'"},
      {without("free_thresh") + "free_threshold: 0.1\n",
       "m.yaml:6: unknown key 'free_threshold'; the nearest valid key is 'free_thresh'"},
      {without("origin") + "Origin: [0, 0, 0]\n",
       "m.yaml:6: unknown key 'Origin'; the nearest valid key is 'origin'"},
      {all + "mdoe: scale\n", "m.yaml:7: unknown key 'mdoe'; the nearest valid key is 'mode'"},
      {"imge: a.pgm\nresolution: 0.05\n" + rest,
       "m.yaml:1: unknown key 'imge'; the nearest valid key is 'image'"},
      {all + "\n<<: {mode: raw}\n", "m.yaml:8: unknown key '<<'; the nearest valid key is 'mode'"},
      {all + "mode: raw\nnegate: 0\n", "m.yaml:8: duplicate key 'negate', first on line 4"},
      {all + "[1]: 2\n", "m.yaml:7: expected a key, got a list, or a bracket that is not closed"},
      {without("image"), "m.yaml:1: image is missing"},
      {without("resolution"), "m.yaml:1: resolution is missing"},
      {without("origin"), "m.yaml:1: origin is missing"},
      {without("negate"), "m.yaml:1: negate is missing"},
      {without("occupied_thresh"), "m.yaml:1: occupied_thresh is missing"},
      {without("free_thresh"), "m.yaml:1: free_thresh is missing"},
      // Values.
      {"image: \"\"\nresolution: 0.05\n" + rest, "m.yaml:1: image: expected a text, got nothing"},
      {"image: [a]\nresolution: 0.05\n" + rest, "m.yaml:1: image: expected a text, got a list"},
      {"image: a\nresolution: 0\n" + rest, "m.yaml:2: resolution must be 0.0001 to 1000, got 0"},
      {"image: a\nresolution: -0.05\n" + rest, "m.yaml:2: resolution must be 0.0001 to 1000, got -0.05"},
      {"image: a\nresolution: nan\n" + rest, "m.yaml:2: resolution must be 0.0001 to 1000, got nan"},
      {"image: a\nresolution: 1e999\n" + rest, "m.yaml:2: resolution must be 0.0001 to 1000, got 1e999"},
      {"image: a\nresolution: 5cm\n" + rest, "m.yaml:2: resolution: expected a number, got '5cm'"},
      {"image: a\nresolution:\n" + rest, "m.yaml:2: resolution: expected a number, got nothing"},
      {with("negate: [0]"), "m.yaml:6: negate: expected 0, 1, false or true, got a list"},
      {with("negate: yES"), "m.yaml:6: negate: expected 0, 1, false or true, got 'yES'"},
      {with("negate:"), "m.yaml:6: negate: expected 0, 1, false or true, got nothing"},
      {with("negate: 2"), "m.yaml:6: negate: expected 0, 1, false or true, got '2'"},
      {with("free_thresh: 1.5"), "m.yaml:6: free_thresh must be 0 to 1, got 1.5"},
      {with("free_thresh: 0.7"), "m.yaml:6: free_thresh 0.7 must not be above occupied_thresh 0.65"},
      {all + "mode: binary\n", "m.yaml:7: mode: expected trinary, scale or raw, got 'binary'"},
      {with("origin: [0, 0]"),
       "m.yaml:6: origin: expected [x, y, yaw] in metres and radians, got a list of 2"},
      {with("origin: 3"), "m.yaml:6: origin: expected [x, y, yaw] in metres and radians, got '3'"},
      {with("origin: [0, 0, [1]]"), "m.yaml:6: origin: expected a number, got a list"},
      {with("origin: [inf, 0, 0]"), "m.yaml:6: origin must be -100000000 to 100000000, got inf"},
      // Not a map YAML at all.
      {"", "m.yaml: image is missing"},
      {",", "m.yaml:1: expected one document, found a second one"},
      {all + "mode: &a raw\n? *a\n", "m.yaml:8: aliases ('*name') are not allowed"},
      {"- image: a\n", "m.yaml:1: expected lines of 'key: value', got a list"},
      {"just a text", "m.yaml:1: expected lines of 'key: value', got 'just a text'"},
      {all + "---\nimage: b\n", "m.yaml:7: expected one document, found a second one"},
      {std::string("BM\x42\0\0\0", 6),
       "m.yaml: is an image: expected the map's YAML file, which names the image"},
      {"P5\n4 4\n255\n", "m.yaml: is an image: expected the map's YAML file, which names the image"},
      {"image: \"\\q\"\n", "m.yaml:1: not valid YAML: unknown escape character: q"},
      {std::string(70000, '#'), "m.yaml: expected a map YAML of at most 64 KiB"},
  };
  for (const Mistake& m : mistakes)
    EXPECT_EQ(error_of([&] { map_yaml_from_text(m.yaml, "m.yaml"); }), m.message) << m.yaml;
}

// What nav2's map_server reads over: keys that it does not ask for, whatever stands behind them.
TEST(MapYaml, OtherKeysAreNoted) {
  const std::string text = "map_type: occupancy\n" + yaml_with("negate: 0") +
                           "\nzones:\n  - {name: a, image: 1}\n  - [1, 2]\nnode: 3\nname: hall\nimages: []\n";
  EXPECT_EQ(map_yaml_from_text(text, "m.yaml").notes,
            (std::vector<std::string>{
                "m.yaml:1: the key 'map_type' is not used", "m.yaml:8: the key 'zones' is not used",
                "m.yaml:11: the key 'node' is not used", "m.yaml:12: the key 'name' is not used",
                "m.yaml:13: the key 'images' is not used"}));
  EXPECT_TRUE(map_yaml_from_text(yaml_with("negate: 0"), "m").notes.empty());
}

TEST(MapYaml, NegateIsABooleanOfYaml11) {
  const auto negate = [](const std::string& word) {
    return map_yaml_from_text(yaml_with("negate: " + word), "m").negate;
  };
  for (const char* word :
       {"1", "true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON", "y", "Y", "\"1\""})
    EXPECT_TRUE(negate(word)) << word;
  for (const char* word : {"0", "false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF", "n", "N"})
    EXPECT_FALSE(negate(word)) << word;
}

TEST(MapYaml, AYawBeyondATurnIsWrappedAndNoted) {
  const auto with_yaw = [](const std::string& yaw) {
    return map_yaml_from_text(yaml_with("negate: 0", "map.pgm", "[0, 0, " + yaw + "]"), "m.yaml");
  };
  EXPECT_NEAR(std::fabs(with_yaw("9.42477796").T_map_grid.theta_rad), 3.14159265, 2e-8);
  EXPECT_NEAR(with_yaw("-20.0").T_map_grid.theta_rad, -20.0 + 6.0 * 3.14159265358979, 1e-12);
  EXPECT_EQ(with_yaw("90").notes,
            (std::vector<std::string>{
                "m.yaml:3: origin: a yaw of 90 rad is more than a turn: taken as 2.03541 rad"}));
  EXPECT_TRUE(with_yaw("6.28").notes.empty());
}

}  // namespace
}  // namespace parloc
