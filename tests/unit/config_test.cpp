// The configuration: strict reading with one clear message per mistake, and printing that reads back.
#include "common/config/config.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/config/config_settings.h"
#include "common/file/nearest_name.h"
#include "common/model/model_settings.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

std::string message_for(const std::string& yaml) {
  return error_of([&] { config_from_text(yaml, "c.yaml"); }, ErrorKind::config);
}
std::string message_for(const Config& config) {
  return error_of([&] { validate(config); }, ErrorKind::config);
}

struct Mistake {
  const char* yaml;
  const char* message;
};

TEST(Config, EachMistakeHasOneClearLine) {
  const std::vector<Mistake> mistakes{
      // Misspelt and misplaced keys.
      {"particels: 5\n", "c.yaml:1: unknown key 'particels'; the nearest valid key is 'particles'"},
      {"\nsensor:\n  sigm_hit: 0.1\n",
       "c.yaml:3: unknown key 'sensor.sigm_hit'; the nearest valid key is 'sensor.sigma_hit'"},
      {"z_hit: 0.9\n", "c.yaml:1: unknown key 'z_hit'; the nearest valid key is 'sensor.z_hit'"},
      {"sensors:\n  z_hit: 1\n", "c.yaml:1: unknown key 'sensors'; the nearest valid key is 'sensor'"},
      {"sensor:\n  particles: 3\n",
       "c.yaml:2: unknown key 'sensor.particles'; the nearest valid key is 'particles'"},
      {"mdel: [1, 2]\n", "c.yaml:1: unknown key 'mdel'; the nearest valid key is 'sensor.model'"},
      {"\"\": 3\n", "c.yaml:1: unknown key ''; the nearest valid key is 'kld'"},
      // Duplicates.
      {"seed: 1\nparticles: 2\nseed: 3\n", "c.yaml:3: duplicate key 'seed', first on line 1"},
      {"scan: {max_beams: 9, max_beams: 9}\n", "c.yaml:1: duplicate key 'scan.max_beams', first on line 1"},
      {"scan:\n  max_beams: 9\nscan:\n  min_beams: 2\n", "c.yaml:3: duplicate key 'scan', first on line 1"},
      // Types.
      {"initial_sigma_xy: abc\n", "c.yaml:1: initial_sigma_xy: expected a number, got 'abc'"},
      {"initial_sigma_xy: 0.1m\n", "c.yaml:1: initial_sigma_xy: expected a number, got '0.1m'"},
      {"initial_sigma_xy: .inf\n", "c.yaml:1: initial_sigma_xy: expected a number, got '.inf'"},
      {"initial_sigma_xy: nan\n", "c.yaml:1: initial_sigma_xy must be 0 to 1000, got nan"},
      {"initial_sigma_xy: 0,1\n", "c.yaml:1: initial_sigma_xy: expected a number, got '0,1'"},
      {"initial_sigma_xy: +-1\n", "c.yaml:1: initial_sigma_xy: expected a number, got '+-1'"},
      {"particles: 2000.0\n", "c.yaml:1: particles: expected a whole number, got '2000.0'"},
      {"particles: \"2000\"\n", "c.yaml:1: particles: expected a whole number, got the text \"2000\""},
      {"particles:\n", "c.yaml:1: particles: expected a whole number, got nothing"},
      {"particles: null\n", "c.yaml:1: particles: expected a whole number, got nothing"},
      {"particles: [1, 2]\n", "c.yaml:1: particles: expected a whole number, got a list"},
      {"particles:\n  seed: 1\n", "c.yaml:2: particles: expected a whole number, got a group"},
      {"motion:\n  symmetric: yes\n", "c.yaml:2: motion.symmetric: expected true or false, got 'yes'"},
      {"motion:\n  form: gauss\n", "c.yaml:2: motion.form: expected seed, thrun or omni, got 'gauss'"},
      {"sensor:\n  caster: DDA\n", "c.yaml:2: sensor.caster: expected skip, dda or fixed_step, got 'DDA'"},
      {"motion: 3\n", "c.yaml:1: motion: expected lines of 'key: value', got '3'"},
      {"- particles\n", "c.yaml:1: expected lines of 'key: value', got a list"},
      {"particles 5\n", "c.yaml:1: expected lines of 'key: value', got 'particles 5'"},
      // Values.
      {"particles: 0\n", "c.yaml:1: particles must be 1 to 16777216, got 0"},
      {"particles: 16777217\n", "c.yaml:1: particles must be 1 to 16777216, got 16777217"},
      {"particles: 99999999999999999999\n",
       "c.yaml:1: particles must be 1 to 16777216, got 99999999999999999999"},
      {"seed: -1\n", "c.yaml:1: seed must be 0 to 18446744073709551615, got -1"},
      {"sensor:\n  effective_beams: 0\n",
       "c.yaml:2: sensor.effective_beams must be above 0 and at most 4096, got 0"},
      {"motion:\n  form: seed\n  alpha3: -0.1\n", "c.yaml:3: motion.alpha3 must be 0 to 100, got -0.1"},
      {"scan:\n  laser_max_range: 1e999\n",
       "c.yaml:2: scan.laser_max_range must be above 0 and at most 1000, got 1e999"},
      // Rules between settings.
      {"motion:\n  alpha1: 0.2\n",
       "c.yaml:2: motion.alpha1 needs motion.form beside it: seed (sigma linear in the motion), thrun "
       "(variance quadratic, as AMCL) or omni (likewise, and sideways)"},
      {"seed: 2\nsensor:\n  z_hit: 0.5\n",
       "c.yaml:3: sensor.z_hit + z_short + z_max + z_rand must be 1, got 0.6 (0.5 + 0 + 0 + 0.1)"},
      {"scan:\n  min_beams: 200\n", "c.yaml:2: scan.min_beams (200) must not exceed scan.max_beams (100)"},
      {"scan:\n  laser_max_range: 0.05\n",
       "c.yaml: scan.laser_min_range (0.1) must be below scan.laser_max_range (0.05)"},
      {"sensor:\n  model: beam\n  z_hit: 0.8\n  z_max: 0\n",
       "c.yaml:4: sensor.z_max must be above 0 with sensor.model beam, else a single beam without return can "
       "rule out every particle"},
      {"sensor:\n  z_hit: 1.0\n  z_rand: 0.0\n",
       "c.yaml:3: sensor.z_rand must be above 0, else a single beam can rule out every particle"},
      // YAML that a configuration has no use for.
      {"seed: &a 1\n", "c.yaml:1: anchors ('&name') are not allowed"},
      {"seed: 1\n---\nseed: 2\n", "c.yaml:2: expected one document, found a second one"},
      {"seed: !!int 1\n", "c.yaml:1: type tags are not allowed, got 'tag:yaml.org,2002:int'"},
      {"? [1, 2]\n: 3\n", "c.yaml:1: expected a key, got a list, or a bracket that is not closed"},
  };
  for (const Mistake& mistake : mistakes)
    EXPECT_EQ(message_for(mistake.yaml), mistake.message) << mistake.yaml;
}

TEST(Config, HostileTextIsAnError) {
  EXPECT_EQ(message_for(std::string("seed: 1\n\0", 9)), "c.yaml:2: expected text, found the byte 0x00");
  EXPECT_EQ(message_for(std::string(1 << 20, ' ')), "c.yaml: expected a configuration of at most 64 KiB");
  expect_parts(message_for("seed: [1, 2\n"), {"c.yaml:"});
  expect_parts(message_for("seed: 1\n\tparticles: 2\n"), {"c.yaml:"});
  for (const char* deep : {"[", "{a: ", "- ", "? ", "seed: [", "&a "}) {  // 60 KiB of nesting
    std::string text;
    while (text.size() < 60000) text += deep;
    EXPECT_FALSE(message_for(text).empty());
  }
  std::string bomb = "a: &a [x, x, x]\n";
  for (char c = 'b'; c < 'z'; ++c) {
    bomb += std::string(1, c) + ": &" + c + " [*" + static_cast<char>(c - 1) + ", *" +
            static_cast<char>(c - 1) + "]\n";
  }
  EXPECT_FALSE(message_for(bomb).empty());
  // A hostile key cannot make a message of many lines.
  expect_none_of(message_for("\"a\\nb\": 1\n"), {"\n"});
}

TEST(Config, NoKeysAreDefaults) {
  const std::string defaults = config_to_yaml(Config{});
  for (const char* text : {"", "\n", "# only a comment\n", "---\n", "motion:\nscan:\n", "{}", "~\n"}) {
    EXPECT_EQ(config_to_yaml(config_from_text(text, "c.yaml")), defaults) << text;
  }
}

// A model may be chosen alone: it brings settings that work, and those of the file win over them.
TEST(Config, EachModelBringsItsOwnDefaults) {
  for (const auto& model : kSensorModels) {
    const Config c = config_from_text(std::string("sensor:\n  model: ") + model.name + "\n", "c.yaml");
    const SensorConfig expected = default_sensor(model.value);
    EXPECT_EQ(c.sensor.model, model.value);
    EXPECT_EQ(c.sensor.sigma_hit, expected.sigma_hit) << model.name;
    EXPECT_EQ(c.sensor.effective_beams, expected.effective_beams) << model.name;
    EXPECT_EQ(c.sensor.z_max, expected.z_max) << model.name;
  }
  const Config c = config_from_text("sensor:\n  tempering: 0.7\n  model: beam\n", "c.yaml");
  EXPECT_EQ(c.sensor.tempering, 0.7);
  EXPECT_EQ(c.sensor.sigma_hit, default_sensor(SensorModel::beam).sigma_hit);
}

TEST(Config, ValuesArrive) {
  const Config c = config_from_text(
      "particles: 16777216\nseed: 18446744073709551615\nbackend: cuda\nupdate_min_d: +1e-1\n"
      "motion: {form: thrun, alpha1: .25, symmetric: false}\n"
      "sensor:\n  model: beam\n  z_hit: 0.7\n  z_short: 0.1\n  z_max: 0.1\n  z_rand: 0.1\n"
      "estimate:\n  mode: \"mean\"\n",
      "c.yaml");
  EXPECT_EQ(c.particles, 16777216);
  EXPECT_EQ(c.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(c.backend, BackendChoice::cuda);
  EXPECT_EQ(c.update_min_d, 0.1);
  EXPECT_EQ(c.motion.form, MotionForm::thrun);
  EXPECT_EQ(c.motion.alpha1, 0.25);
  EXPECT_FALSE(c.motion.symmetric);
  EXPECT_EQ(c.sensor.model, SensorModel::beam);
  EXPECT_EQ(c.sensor.z_short, 0.1);
  EXPECT_EQ(c.estimate.mode, EstimateMode::mean);
}

/// Gives every setting a value that is not its default, yet allowed.
struct Changer {
  template <class Number>
  void operator()(const NumberSetting<Number>& number) const {
    const Number value = *number.slot.get(), low = number.limits.low;
    // Between the default and the lower limit, at a place that needs all 17 digits.
    const auto between = static_cast<Number>(low + (value - low) / 3);
    number.slot.set(is_share         ? static_cast<Number>(0.25)  // four shares that sum to 1
                    : between == low ? number.limits.high
                                     : between);
  }
  void operator()(const FlagSetting& flag) const { flag.set(!*flag.get()); }
  void operator()(const TextSetting& text) const { *text.text = "/robot1/scan"; }
  void operator()(const ChoiceSetting& choice) const {
    const bool is_first = choice.name() == std::string(choice.names.front().first);
    choice.choose(is_first ? choice.names.size() - 1 : 0);
  }
  void operator()(const IntervalsSetting& list) const { list.set({{list.limits.low, list.limits.high / 3}}); }
  bool is_share;
};

TEST(Config, LidarsHaveAnEntryEach) {
  const Config c = config_from_text(
      "lidars:\n  front: {x: 0.2, y: -0.1, yaw: 0.5}\n"
      "  robotlaser2:\n    upside_down: true\n    max_beams: 40\n    min_range: 0.05\n    max_range: 12\n"
      "    scan_time: 0.025\n    stamp_at: last\n    zero_policy: miss\n  rear:\nseed: 7\n",
      "c.yaml");
  EXPECT_EQ(c.seed, 7u);
  ASSERT_EQ(c.lidars.size(), 2u);  // rear says nothing
  const LidarConfig &front = c.lidars[0], &other = c.lidars[1];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.x, 0.2);
  EXPECT_EQ(front.y, -0.1);
  EXPECT_EQ(front.yaw, 0.5);
  EXPECT_FALSE(front.upside_down.has_value());
  EXPECT_FALSE(front.max_beams || front.min_range || front.scan_time);
  EXPECT_EQ(other.name, "robotlaser2");
  EXPECT_FALSE(other.x || other.y || other.yaw);
  EXPECT_EQ(other.upside_down, true);
  EXPECT_EQ(other.max_beams, 40);
  EXPECT_EQ(other.min_range, 0.05);
  EXPECT_EQ(other.max_range, 12.0);
  EXPECT_EQ(other.scan_time, 0.025);
  EXPECT_EQ(other.stamp_at, StampAt::last);
  EXPECT_EQ(other.zero_policy, ZeroPolicy::miss);
  const std::string printed = config_to_yaml(c);
  EXPECT_EQ(config_to_yaml(config_from_text(printed, "printed")), printed);
  expect_parts(printed, {"\n  robotlaser2:\n"});
}

TEST(Config, AnglesAndMasksOfALidar) {
  const Config c = config_from_text(
      "lidars:\n  front: {angle_min: -2.356, angle_step: 0.0087, flipped: true, mask: [[-0.3, 0.2], [3, "
      "-3]]}\n"
      "  rear: {mask: [1.5, 1.75]}\n",
      "c.yaml");
  ASSERT_EQ(c.lidars.size(), 2u);
  EXPECT_EQ(c.lidars[0].angle_min, -2.356);
  EXPECT_EQ(c.lidars[0].angle_step, 0.0087);
  EXPECT_EQ(c.lidars[0].flipped, true);
  ASSERT_EQ(c.lidars[0].mask.size(), 2u);
  EXPECT_EQ(c.lidars[0].mask[1].from, 3.0);
  EXPECT_EQ(c.lidars[0].mask[1].to, -3.0);
  ASSERT_EQ(c.lidars[1].mask.size(), 1u) << "one interval needs no list of them";
  EXPECT_EQ(c.lidars[1].mask[0].to, 1.75);
  const std::string printed = config_to_yaml(c);
  EXPECT_EQ(config_to_yaml(config_from_text(printed, "printed")), printed);
  expect_parts(printed, {"mask: [[-0.3, 0.2], [3, -3]]"});
}

TEST(Config, TheExampleOfALidarIsValid) {
  std::string printed = config_to_yaml(Config{});
  const std::size_t begin = printed.find("# lidars:");
  ASSERT_NE(begin, std::string::npos);
  std::string example = printed.substr(begin);
  for (std::size_t at = 0; at != std::string::npos;) {  // uncomment
    example.erase(at, 2);
    const std::size_t next = example.find('\n', at);
    at = next == std::string::npos || next + 1 >= example.size() ? std::string::npos : next + 1;
  }
  const Config c = config_from_text(example, "example");
  ASSERT_EQ(c.lidars.size(), 1u);
  EXPECT_TRUE(c.lidars[0].x && c.lidars[0].min_range && c.lidars[0].stamp_at);
}

TEST(Config, MistakesInLidarsHaveOneClearLine) {
  const std::vector<Mistake> mistakes{
      {"lidars: 3\n", "c.yaml:1: lidars: expected lines of 'key: value', got '3'"},
      {"lidars: [1]\n", "c.yaml:1: lidars: expected lines of 'key: value', got a list"},
      {"lidars:\n  front: 3\n", "c.yaml:2: lidars.front: expected lines of 'key: value', got '3'"},
      {"lidars:\n  front: [3]\n", "c.yaml:2: lidars.front: expected lines of 'key: value', got a list"},
      {"lidars:\n  front:\n    yav: 0\n",
       "c.yaml:3: unknown key 'lidars.front.yav'; the nearest valid key is 'lidars.front.yaw'"},
      {"lidars:\n  front:\n    x: {a: 1}\n", "c.yaml:3: lidars.front.x: expected a number, got a group"},
      {"lidars:\n  front:\n    yaw: left\n", "c.yaml:3: lidars.front.yaw: expected a number, got 'left'"},
      {"lidars:\n  front:\n    yaw: 90\n", "c.yaml:3: lidars.front.yaw must be -6.3 to 6.3, got 90"},
      {"lidars:\n  front:\n    upside_down: 1\n",
       "c.yaml:3: lidars.front.upside_down: expected true or false, got '1'"},
      {"lidars:\n  front: {angle_step: 0}\n", "c.yaml:2: lidars.front.angle_step must not be 0"},
      {"lidars:\n  front: {upside_down: true, flipped: false}\n",
       "c.yaml:2: lidars.front.flipped is another word for lidars.front.upside_down: they must not differ"},
      {"lidars:\n  front:\n    mask: 3\n",
       "c.yaml:3: lidars.front.mask: expected a list of up to 32 intervals [from, to], got '3'"},
      {"lidars:\n  front:\n    mask: [[1, 2], [3]]\n",
       "c.yaml:3: lidars.front.mask: expected a list of up to 32 intervals [from, to], got one that is not"},
      {"lidars:\n  front:\n    mask: [[1, 90]]\n", "c.yaml:3: lidars.front.mask must be -6.3 to 6.3, got 90"},
      {"lidars:\n  front:\n    stamp_at: end\n",
       "c.yaml:3: lidars.front.stamp_at: expected first, middle or last, got 'end'"},
      {"lidars:\n  front: {x: 1}\n  front: {y: 1}\n",
       "c.yaml:3: duplicate key 'lidars.front', first on line 2"},
      {"lidars:\n  front: {x: 1, x: 2}\n", "c.yaml:2: duplicate key 'lidars.front.x', first on line 2"},
      {"lidars:\n  a b: {x: 1}\n",
       "c.yaml:2: lidars: 'a b' is no name of a LiDAR: expected 1 to 40 letters, digits, '_' or '-'"},
      {"lidars:\n  front:\n    max_range: 2\n    min_range: 2\n",
       "c.yaml:4: lidars.front.min_range (2) must be below lidars.front.max_range (2)"},
      {"lidars:\n  front: {max_beams: 3}\n",
       "c.yaml:2: lidars.front.max_beams (3) must not be below scan.min_beams (5)"},
      {"lidar:\n  front: {x: 3}\n", "c.yaml:1: unknown key 'lidar'; the nearest valid key is 'lidars'"},
      {"scan:\n  scan_time: 2\n", "c.yaml:2: scan.scan_time must be 0 to 1, got 2"},
      {"x: 3\n", "c.yaml:1: unknown key 'x'; the nearest valid key is"},
  };
  for (const Mistake& m : mistakes)
    EXPECT_EQ(message_for(m.yaml).substr(0, std::string(m.message).size()), m.message) << m.yaml;
  Config twice;
  twice.lidars = {{.name = "front"}, {.name = "front"}};
  EXPECT_EQ(message_for(twice), "lidars.front is there twice");
}

TEST(Config, PrintedConfigurationReadsBack) {
  Config changed;
  for (const Setting& s : settings_of(changed).all) std::visit(Changer{s.key.rfind("z_", 0) == 0}, s.value);
  changed.scan.min_beams = 3;
  changed.scan.laser_min_range = 0.1 / 3;
  const std::string yaml = config_to_yaml(changed);
  EXPECT_EQ(config_to_yaml(config_from_text(yaml, "printed")), yaml);
  // Bit for bit, not only as printed; and every key was really changed and read.
  const Config again = config_from_text(yaml, "printed");
  EXPECT_EQ(again.motion.alpha1, changed.motion.alpha1);
  EXPECT_EQ(again.scan.laser_min_range, 0.1 / 3);
  std::size_t differing_lines = 0;
  const std::string defaults = config_to_yaml(Config{});
  for (std::size_t a = 0, b = 0; a < yaml.size() && b < defaults.size();) {
    const std::size_t a_end = yaml.find('\n', a), b_end = defaults.find('\n', b);
    differing_lines += yaml.substr(a, a_end - a) != defaults.substr(b, b_end - b);
    a = a_end + 1;
    b = b_end + 1;
  }
  EXPECT_EQ(differing_lines, settings_of(changed).all.size());
}

TEST(Config, EveryGroupHasItsHeading) {
  Config config;
  const Settings settings = settings_of(config);
  for (const Setting& setting : settings.all) {
    bool known = setting.group.empty();
    for (const SettingGroup& group : settings.groups) known = known || group.name == setting.group;
    EXPECT_TRUE(known) << setting.name();
  }
}

TEST(Config, ValidateChecksAStructToo) {
  EXPECT_NO_THROW(validate(Config{}));
  Config config;
  config.particles = 0;
  EXPECT_EQ(message_for(config), "particles must be 1 to 16777216, got 0");
  config = {};
  config.sensor.sigma_hit = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_for(config), "sensor.sigma_hit must be 0.001 to 10, got nan");
  config = {};
  config.sensor.z_rand = 0.1 + 2e-6;
  EXPECT_FALSE(message_for(config).empty());
  config.sensor.z_rand = 0.1 + 0.5e-6;
  EXPECT_NO_THROW(validate(config));
  config = {};
  config.sensor.caster = static_cast<RayCaster>(77);
  EXPECT_FALSE(message_for(config).empty());
}

TEST(Config, FilesThatCannotBeRead) {
  const auto message = [](const char* path) {
    return error_of([&] { read_config(path); }, ErrorKind::config);
  };
  EXPECT_EQ(message("/nonexistent/c.yaml"),
            "/nonexistent/c.yaml: cannot be opened: No such file or directory");
  EXPECT_EQ(message("/"), "/: cannot be read (is it a folder?)");
  EXPECT_EQ(message("/dev/zero"), "/dev/zero: expected a configuration of at most 64 KiB");
}

TEST(EditDistance, CountsLetters) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("z_hit", "z_hit"), 0u);
  EXPECT_EQ(edit_distance("particels", "particles"), 2u);  // a swap is two changes
}

}  // namespace
}  // namespace parloc
