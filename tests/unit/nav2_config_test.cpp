// Parameter files of nav2 as configurations: which amcl is read, what each parameter becomes, and one clear
// line per mistake.
#include "common/config/nav2_config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "common/config/config_settings.h"
#include "common/config/nav2_parameters.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

ConfigFile read(const std::string& text) {
  return config_file_from_text(text, "n.yaml");
}
ConfigFile amcl(const std::string& lines) {
  return read("amcl:\n  ros__parameters:\n" + lines);
}
std::string message_for(const std::string& text) {
  return error_of([&] { read(text); }, ErrorKind::config);
}
/// What became of a parameter.
std::string told(const ConfigFile& file, const std::string& name) {
  for (const Nav2Line& line : file.lines)
    if (line.name == name) return line.text;
  return "nothing";
}
std::size_t count(const ConfigFile& file, Nav2Line::Kind kind) {
  return static_cast<std::size_t>(
      std::count_if(file.lines.begin(), file.lines.end(), [&](const Nav2Line& l) { return l.kind == kind; }));
}

/// All that nav2_bringup's file says, in other words.
const char* const kBringup =
    "    use_sim_time: True\n    alpha1: 0.21\n    alpha2: 0.22\n    alpha3: 0.23\n    alpha4: 0.24\n    "
    "alpha5: 0.25\n"
    "    base_frame_id: \"base_footprint\"\n    beam_skip_distance: 0.51\n    beam_skip_error_threshold: "
    "0.91\n"
    "    beam_skip_threshold: 0.31\n    do_beamskip: True\n    global_frame_id: \"map\"\n    lambda_short: "
    "0.1\n"
    "    laser_likelihood_max_dist: 1.5\n    laser_max_range: 100\n    laser_min_range: -1.0\n"
    "    laser_model_type: \"likelihood_field_prob\"\n    max_beams: 61\n    max_particles: 2001\n"
    "    min_particles: 501\n    odom_frame_id: \"odom\"\n    pf_err: 0.06\n    pf_z: 0.98\n"
    "    recovery_alpha_fast: 0.1\n    recovery_alpha_slow: 0.001\n    resample_interval: 1\n"
    "    robot_model_type: \"nav2_amcl::DifferentialMotionModel\"\n    save_pose_rate: 0.5\n    sigma_hit: "
    "0.19\n"
    "    tf_broadcast: true\n    transform_tolerance: 1.0\n    update_min_a: 0.2\n    update_min_d: 0.26\n"
    "    z_hit: 0.5\n    z_max: 0.05\n    z_rand: 0.5\n    z_short: 0.05\n    scan_topic: scan\n";

TEST(Nav2Config, WhatMeansTheSameIsTaken) {
  const ConfigFile file = amcl(kBringup);
  const Config& c = file.config;
  EXPECT_EQ(file.nav2_node, "/amcl");
  EXPECT_EQ(c.motion.form, MotionForm::thrun);
  EXPECT_EQ(c.motion.alpha1, 0.21);
  EXPECT_EQ(c.motion.alpha5, 0.25);
  EXPECT_EQ(c.sensor.model, SensorModel::likelihood_field_prob);
  EXPECT_TRUE(c.sensor.do_beamskip);
  EXPECT_EQ(c.sensor.beam_skip_distance, 0.51);
  EXPECT_EQ(c.sensor.beam_skip_error_threshold, 0.91);
  EXPECT_EQ(c.sensor.beam_skip_threshold, 0.31);
  EXPECT_EQ(c.sensor.laser_likelihood_max_dist, 1.5);
  EXPECT_EQ(c.sensor.sigma_hit, 0.19);
  EXPECT_EQ(c.sensor.z_hit, 0.5);
  EXPECT_EQ(c.sensor.z_rand, 0.5);
  EXPECT_EQ(c.sensor.z_short, 0.0);
  EXPECT_EQ(c.scan.max_beams, 61);
  EXPECT_EQ(c.scan.laser_max_range, 100.0);
  EXPECT_EQ(c.scan.laser_min_range, Config().scan.laser_min_range);
  EXPECT_EQ(c.max_particles, 2001);
  EXPECT_EQ(c.min_particles, 501);
  EXPECT_EQ(c.kld.pf_err, 0.06);
  EXPECT_EQ(c.kld.pf_z, 0.98);
  EXPECT_EQ(c.recovery.recovery_alpha_fast, 0.1);
  EXPECT_EQ(c.recovery.recovery_alpha_slow, 0.001);
  EXPECT_EQ(c.resample.threshold, 1.0);
  EXPECT_EQ(c.update_min_d, 0.26);
  EXPECT_EQ(c.update_min_a, 0.2);
  EXPECT_FALSE(file.nav2_start);
  EXPECT_EQ(file.lines.size(), 38u);
  EXPECT_EQ(count(file, Nav2Line::Kind::no_meaning), 7u);
  EXPECT_EQ(c.log.scan_topic, "scan");
  EXPECT_EQ(c.log.base_frame, "base_footprint");
  EXPECT_EQ(c.log.odometry_frame, "");
  EXPECT_EQ(count(file, Nav2Line::Kind::unknown), 0u);
  EXPECT_EQ(told(file, "sigma_hit"), "sensor.sigma_hit: 0.19");
  EXPECT_EQ(told(file, "laser_max_range"), "scan.laser_max_range: 100 (where the log gives none)");
  EXPECT_EQ(told(file, "z_short"), "only laser_model_type: beam reads it, in nav2 too");
  EXPECT_EQ(told(file, "odom_frame_id"), "as it is without");
  EXPECT_EQ(told(file, "scan_topic"), "log.scan_topic: \"scan\"");
  EXPECT_EQ(
      nav2_summary(file, "n.yaml"),
      (std::vector<std::string>{
          "n.yaml: nav2's settings of /amcl: 31 parameters taken; parloc config --config n.yaml lists them",
          "n.yaml: 7 have no meaning here: use_sim_time, global_frame_id, save_pose_rate, tf_broadcast, "
          "transform_tolerance, z_max, z_short"}));
  // What was translated is a configuration that reads back as itself.
  EXPECT_EQ(config_to_yaml(config_from_text(config_to_yaml(c), "printed")), config_to_yaml(c));
}

TEST(Nav2Config, WhatTheFileDoesNotSayIsAsItWas) {
  EXPECT_EQ(config_to_yaml(amcl("    tf_broadcast: true\n").config), config_to_yaml({}));
  Config base;
  base.sensor.sigma_hit = 0.3;
  const ConfigFile file =
      config_file_from_text("amcl:\n  ros__parameters:\n    max_beams: 3\n", "n.yaml", base);
  EXPECT_EQ(file.config.sensor.sigma_hit, 0.3);
  EXPECT_EQ(file.config.scan.max_beams, 3);
  EXPECT_EQ(file.config.scan.min_beams, 3);
}

TEST(Nav2Config, TheNodeIsFoundUnderItsNamespace) {
  const std::string body = "ros__parameters: {max_beams: 33}";
  const std::pair<std::string, std::string> files[] = {
      {"amcl: {" + body + "}", "/amcl"},
      {"/amcl: {" + body + "}", "/amcl"},
      {"robot1: {amcl: {" + body + "}}", "/robot1/amcl"},
      {"/robot1/amcl: {" + body + "}", "/robot1/amcl"},
      {"/fleet: {robot1/amcl: {" + body + "}}", "/fleet/robot1/amcl"},
      {"/**: {amcl: {" + body + "}}", "/**/amcl"},
      {"/**/amcl: {" + body + "}", "/**/amcl"},
      {"/**: {" + body + "}", "/**"},
      {"map_server: {ros__parameters: {max_beams: 5}}\n\"amcl\": {" + body + "}", "/amcl"},
      {"amcl: {" + body + "}\n/**: {ros__parameters: {max_beams: 44, use_sim_time: true}}", "/amcl"}};
  for (const auto& [text, node] : files) {
    const ConfigFile file = read(text);
    EXPECT_EQ(file.nav2_node, node) << text;
    EXPECT_EQ(file.config.scan.max_beams, 33) << text;
  }
  EXPECT_EQ(read("/**: {ros__parameters: {sigma_hit: 0.3}}\namcl: {" + body + "}").config.sensor.sigma_hit,
            0.3);
}

// There a threshold of 0 is passed by any motion; here it is none.
TEST(Nav2Config, AThresholdOfZeroIsAnyMotion) {
  for (const char* text :
       {"    update_min_d: 0.0\n    update_min_a: 0.2\n", "    update_min_d: 0.3\n    update_min_a: 0\n"}) {
    const ConfigFile file = amcl(text);
    EXPECT_EQ(file.config.update_min_d, 0.0);
    EXPECT_EQ(file.config.update_min_a, 0.0);
    expect_parts(told(file, "update_min_d"), {"any motion counts, so every scan"});
  }
  const ConfigFile one = amcl("    update_min_d: 0.3\n");
  EXPECT_EQ(one.config.update_min_d, 0.3);
  EXPECT_EQ(one.config.update_min_a, 0.0);  // none: nav2's own default is not taken
}

TEST(Nav2Config, SharesAreScaledToOne) {
  const Config field = amcl("    z_hit: 0.95\n    z_rand: 0.15\n    z_max: 0.5\n").config;
  EXPECT_NEAR(field.sensor.z_hit, 0.95 / 1.1, 1e-12);
  EXPECT_NEAR(field.sensor.z_rand, 0.15 / 1.1, 1e-12);
  EXPECT_EQ(field.sensor.z_max, 0.0);
  const ConfigFile beam = amcl(
      "    laser_model_type: beam\n    z_hit: 0.5\n    z_max: 0.05\n    z_rand: 0.5\n    z_short: 0.05\n");
  EXPECT_NEAR(beam.config.sensor.z_short, 0.05 / 1.1, 1e-12);
  EXPECT_NEAR(beam.config.sensor.z_max, 0.05 / 1.1, 1e-12);
  expect_parts(told(beam, "z_hit"), {"sensor.z_hit: 0.4545", "(scaled: the shares sum to 1)"});
}

TEST(Nav2Config, MotionModels) {
  const auto form = [](const std::string& lines) { return amcl(lines).config.motion.form; };
  EXPECT_EQ(form("    robot_model_type: nav2_amcl::OmniMotionModel\n    alpha1: 0.3\n"), MotionForm::omni);
  EXPECT_EQ(form("    robot_model_type: differential\n"), MotionForm::thrun);
  EXPECT_EQ(form("    alpha2: 0.3\n"), MotionForm::thrun);  // nav2's default, which alphas are for
  EXPECT_EQ(form("    max_beams: 30\n"), MotionForm::seed);
}

TEST(Nav2Config, AStart) {
  const ConfigFile file =
      amcl("    set_initial_pose: yes\n    initial_pose: {x: 1.5, y: -2, z: 0.0, yaw: 7.0}\n");
  ASSERT_TRUE(file.nav2_start);
  expect_near(*file.nav2_start, {1.5, -2.0, 7.0 - 2.0 * 3.14159265358979}, 0.0, 1e-12);
  EXPECT_EQ(told(file, "initial_pose.z"), "poses are in the plane");
  EXPECT_TRUE(amcl("    set_initial_pose: true\n    initial_pose.x: 3.0\n").nav2_start);
  const ConfigFile without = amcl("    initial_pose.x: 3.0\n");
  EXPECT_FALSE(without.nav2_start);
  EXPECT_EQ(told(without, "initial_pose.x"), "set_initial_pose is not true");
}

TEST(Nav2Config, OthersAreTold) {
  const ConfigFile file = amcl(
      "    alhpa1: 0.2\n    laser_z_hits: [1, 2]\n    resample_interval: 2\n    random_seed: -1\n"
      "    qos_overrides: {/scan: {depth: 3}}\n");
  EXPECT_EQ(told(file, "alhpa1"), "no parameter of amcl; the nearest is 'alpha1'");
  EXPECT_EQ(told(file, "laser_z_hits"), "no parameter of amcl");
  EXPECT_EQ(told(file, "qos_overrides./scan.depth"), "no parameter of amcl");
  EXPECT_EQ(told(file, "resample_interval"), "parloc resamples by N_eff, not by counting");
  EXPECT_EQ(nav2_listing(file)[0], "not used  alhpa1: 0.2 -> no parameter of amcl; the nearest is 'alpha1'");
  EXPECT_EQ(nav2_summary(file, "n.yaml").back(),
            "n.yaml: 3 are no parameters of amcl: alhpa1, laser_z_hits, qos_overrides./scan.depth");
  EXPECT_EQ(amcl("    random_seed: 7\n").config.seed, 7u);
  EXPECT_TRUE(nav2_summary(read("particles: 5\n"), "p.yaml").empty());
}

TEST(Nav2Config, EachMistakeHasOneClearLine) {
  const std::string head = "amcl:\n  ros__parameters:\n    max_beams: 40\n";
  const std::pair<std::string, std::string> mistakes[] = {
      {head + "    sigma_hit: wide\n", "n.yaml:4: sigma_hit: expected a number, got 'wide'"},
      {head + "    sigma_hit: \"0.2\"\n", "n.yaml:4: sigma_hit: expected a number, got the text \"0.2\""},
      {head + "    sigma_hit: -0.2\n", "n.yaml:4: sigma_hit must be 0.001 to 10, got -0.2"},
      {head + "    max_particles: 2000.0\n",
       "n.yaml:4: max_particles: expected a whole number, got '2000.0'"},
      {head + "    max_particles: [1]\n", "n.yaml:4: max_particles: expected a whole number, got a list"},
      {head + "    do_beamskip: 1\n", "n.yaml:4: do_beamskip: expected true or false, got '1'"},
      {head + "    set_initial_pose: maybe\n",
       "n.yaml:4: set_initial_pose: expected true or false, got 'maybe'"},
      {head + "    laser_max_range: far\n", "n.yaml:4: laser_max_range: expected a number, got 'far'"},
      {head + "    laser_model_type: s5\n",
       "n.yaml:4: laser_model_type: expected beam, likelihood_field or likelihood_field_prob, got 's5'"},
      {head + "    robot_model_type: tank\n",
       "n.yaml:4: robot_model_type: expected nav2_amcl::DifferentialMotionModel or "
       "nav2_amcl::OmniMotionModel, "
       "got 'tank'"},
      {head + "    resample_interval: 0\n", "n.yaml:4: resample_interval must be at least 1, got 0"},
      {head + "    min_particles: 900\n    max_particles: 800\n",
       "n.yaml:4: min_particles (900) must not exceed max_particles (800)"},
      {head + "    recovery_alpha_slow: 0.1\n    recovery_alpha_fast: 0.01\n",
       "n.yaml:4: recovery.recovery_alpha_slow (0.1) must be above 0 and not above "
       "recovery.recovery_alpha_fast "
       "(0.01), or both 0"},
      {head + "    z_rand: 0.0\n    z_hit: 1.0\n",
       "n.yaml:4: sensor.z_rand must be above 0, else a single beam can rule out every particle"},
      {head + "    max_beams: 50\n",
       "n.yaml:4: duplicate key 'amcl.ros__parameters.max_beams', first on line 3"},
      {"a/amcl: {ros__parameters: {}}\nb/amcl: {ros__parameters: {}}\n",
       "n.yaml:2: expected the parameters of one amcl, found those of /a/amcl, /b/amcl"},
      {"map_server: {ros__parameters: {}}\n/**: {ros__parameters: {use_sim_time: true}}\n",
       "n.yaml:1: expected 'amcl:' with ros__parameters, found those of /map_server, /**"},
      {"amcl:\n  ros__parameters: [1\n", "n.yaml:3: not valid YAML: end of sequence flow not found"},
      {"ros__parameters" + std::string(1100000, ' '),
       "n.yaml: expected a parameter file of ROS 2 of at most 1 MiB"}};
  for (const auto& [text, message] : mistakes) EXPECT_EQ(message_for(text), message) << text.substr(0, 200);
}

// Every row of the table has one in the documentation, with the same default and setting, and a setting that
// exists.
TEST(Nav2Parameters, HaveARowInTheDocumentation) {
  std::ifstream file(std::string(PARLOC_SOURCE_DIR) + "/docs/nav2.md");
  std::stringstream docs;
  docs << file.rdbuf();
  Config config;
  const Settings settings = settings_of(config);
  EXPECT_GE(nav2_parameters().size(), 50u);
  for (const Nav2Parameter& p : nav2_parameters()) {
    const std::string cell = *p.setting == '\0' ? "none" : "`" + std::string(p.setting) + "`";
    const std::string row =
        "| `" + std::string(p.name) + "` | " + p.default_text + " | " + cell + " | " + p.why + " |";
    EXPECT_NE(docs.str().find(row), std::string::npos) << row;
    const bool exists = *p.setting == '\0' || *p.setting == '-' ||
                        std::any_of(settings.all.begin(), settings.all.end(),
                                    [&](const Setting& s) { return s.name() == p.setting; });
    EXPECT_TRUE(exists) << p.setting;
  }
}

}  // namespace
}  // namespace parloc
