#include "common/config/nav2_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <variant>

#include "common/config/config_settings.h"
#include "common/config/nav2_file.h"
#include "common/config/nav2_parameters.h"
#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/file/yaml_boolean.h"
#include "common/file/yaml_section.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kFarthest_m = 1e8;  // farther than any map projection reaches

/// Takes the parameters of one amcl into a configuration, one after the other.
class Translation {
 public:
  Translation(const Nav2File& nav2, const std::string& file, ConfigFile& result)
      : nav2_(nav2), file_(file), result_(result), settings_(settings_of(result.config)) {}

  void run() {
    take_models();
    for (const Nav2Value& value : nav2_.values) take(value);
    scale_shares();
    Config& c = result_.config;
    c.scan.min_beams = std::min(c.scan.min_beams, c.scan.max_beams);  // so few are meant to be used
    take_start();
    if (const auto violation = first_violation(c))
      throw file_error(ErrorKind::config, file_, line_of(violation->name), violation->message);
  }

 private:
  using Kind = Nav2Line::Kind;

  const Nav2Value* find(std::string_view name) const {
    for (const Nav2Value& value : nav2_.values)
      if (value.name == name) return &value;
    return nullptr;
  }
  [[noreturn]] void fail(const Nav2Value& value, const std::string& wrong) const {
    throw file_error(ErrorKind::config, file_, value.line, value.name + wrong);
  }
  std::size_t line_of(const std::string& setting) const {
    const auto found = lines_.find(setting);
    return found == lines_.end() ? 0 : found->second;
  }
  void tell(const Nav2Value& value, Kind kind, std::string text) {
    const bool scalar = value.kind == YamlKind::plain || value.kind == YamlKind::quoted;
    result_.lines.push_back({kind, printable(value.name),
                             scalar ? printable(value.text) : described(value.kind, value.text),
                             std::move(text)});
  }
  void tell_taken(const Nav2Value& value, const std::string& setting, const std::string& note = {}) {
    lines_[setting] = value.line;
    for (const Setting& known : settings_.all)
      if (known.name() == setting)
        tell(value, Kind::taken,
             fmt::format("{}: {}{}", setting, value_text(known).value_or(""),
                         note.empty() ? "" : " (" + note + ")"));
  }

  double number(const Nav2Value& value, double low, double high) const {
    double result = 0.0;
    const std::string wrong = read_number(value.kind, value.text, result, low, high);
    if (!wrong.empty()) fail(value, wrong);
    return result;
  }
  std::int64_t whole_number(const Nav2Value& value) const {
    constexpr std::int64_t most = 2'147'483'647;
    std::int64_t result = 0;
    const std::string wrong = read_number(value.kind, value.text, result, -most, most);
    if (!wrong.empty()) fail(value, wrong);
    return result;
  }
  bool boolean(const Nav2Value& value) const {
    const auto result = value.kind == YamlKind::plain ? yaml_boolean(value.text) : std::nullopt;
    if (!result) fail(value, ": expected true or false, got " + described(value.kind, value.text));
    return *result;
  }

  /// Reads a value into the setting, within its limits.
  void set(const Nav2Value& value, const std::string& name) {
    for (const Setting& setting : settings_.all)
      if (setting.name() == name)
        std::visit([&](const auto& of_kind) { set_slot(value, of_kind); }, setting.value);
  }
  template <class Number>
  void set_slot(const Nav2Value& value, const NumberSetting<Number>& setting) const {
    Number number{};
    const std::string wrong = read_number(value.kind, value.text, number, setting.limits.low,
                                          setting.limits.high, setting.limits.above_low);
    if (!wrong.empty()) fail(value, wrong);
    setting.slot.set(number);
  }
  void set_slot(const Nav2Value& value, const FlagSetting& setting) const { setting.set(boolean(value)); }
  void set_slot(const Nav2Value& value, const TextSetting& setting) const {
    if (value.kind != YamlKind::plain && value.kind != YamlKind::quoted)
      fail(value, ": expected a name, got " + described(value.kind, value.text));
    *setting.text = value.text;
  }
  void set_slot(const Nav2Value& value, const auto&) const { fail(value, ": cannot be read"); }

  /// First of all: they decide other defaults and what other parameters mean.
  void take_models();
  void take_motion_model();
  void take(const Nav2Value& value);
  void take_adapted(const Nav2Value& value, const Nav2Parameter& parameter);
  void take_range(const Nav2Value& value, const Nav2Parameter& parameter);
  void take_share(const Nav2Value& value, const Nav2Parameter& parameter);
  void scale_shares();
  void take_start();

  /// A threshold of 0 is none here, but the least of motions there.
  bool any_motion_counts() const {
    const auto is_zero = [&](const char* name) {
      const Nav2Value* value = find(name);
      return value != nullptr && number(*value, 0.0, 100.0) == 0.0;
    };
    return is_zero("update_min_d") || is_zero("update_min_a");
  }
  bool reads_all_shares() const { return result_.config.sensor.model == SensorModel::beam; }

  const Nav2File& nav2_;
  const std::string& file_;
  ConfigFile& result_;
  Settings settings_;
  std::map<std::string, std::size_t> lines_;  ///< Where the file decides a setting.
};

void Translation::take_models() {
  if (const Nav2Value* value = find("laser_model_type")) {
    const std::pair<const char*, SensorModel> models[]{
        {"beam", SensorModel::beam},
        {"likelihood_field", SensorModel::likelihood_field},
        {"likelihood_field_prob", SensorModel::likelihood_field_prob}};
    const auto found = std::find_if(std::begin(models), std::end(models),
                                    [&](const auto& model) { return value->text == model.first; });
    if (found == std::end(models))
      fail(*value,
           fmt::format(": expected {}, got {}", choices_text(models), described(value->kind, value->text)));
    result_.config.sensor = default_sensor(found->second);
  }
  take_motion_model();
}

void Translation::take_motion_model() {
  MotionForm& form = result_.config.motion.form;
  if (const Nav2Value* value = find("robot_model_type")) {
    const auto names = [&](std::initializer_list<const char*> known) {
      return std::find(known.begin(), known.end(), value->text) != known.end();
    };
    if (names({"nav2_amcl::DifferentialMotionModel", "differential"})) {
      form = MotionForm::thrun;
    } else if (names({"nav2_amcl::OmniMotionModel", "omnidirectional", "omni"})) {
      form = MotionForm::omni;
    } else {
      fail(*value, ": expected nav2_amcl::DifferentialMotionModel or nav2_amcl::OmniMotionModel, got " +
                       described(value->kind, value->text));
    }
    return;
  }
  const bool has_alpha = std::any_of(nav2_.values.begin(), nav2_.values.end(),
                                     [](const Nav2Value& v) { return v.name.starts_with("alpha"); });
  if (has_alpha && form == MotionForm::seed) form = MotionForm::thrun;  // what they are for without a word
}

void Translation::take(const Nav2Value& value) {
  const Nav2Parameter* parameter = nav2_parameter(value.name);
  if (parameter == nullptr) {
    std::vector<std::string_view> names;
    for (const Nav2Parameter& known : nav2_parameters()) names.push_back(known.name);
    const std::string_view nearest = nearest_name(value.name, names);
    const bool is_near = edit_distance(value.name.substr(0, 100), nearest) <= 3;
    tell(
        value, Kind::unknown,
        is_near ? fmt::format("no parameter of amcl; the nearest is '{}'", nearest) : "no parameter of amcl");
    return;
  }
  if (parameter->fate == Nav2Fate::none) return tell(value, Kind::no_meaning, parameter->why);
  if (parameter->fate == Nav2Fate::adapted) return take_adapted(value, *parameter);
  if (value.name.starts_with("update_min_") && any_motion_counts()) {
    result_.config.update_min_d = result_.config.update_min_a = 0.0;
    return tell_taken(value, parameter->setting, "one of them is 0: any motion counts, so every scan");
  }
  if (value.name == "min_particles" && whole_number(value) == 0) {
    result_.config.min_particles = 1;  // 0 stands for something else here
  } else {
    set(value, parameter->setting);
  }
  tell_taken(value, parameter->setting);
}

void Translation::take_adapted(const Nav2Value& value, const Nav2Parameter& parameter) {
  const std::string& name = value.name;
  if (name == "laser_model_type" || name == "robot_model_type") {
    tell_taken(value, parameter.setting);
  } else if (name == "laser_max_range" || name == "laser_min_range") {
    take_range(value, parameter);
  } else if (name == "random_seed") {
    const std::int64_t seed = whole_number(value);
    if (seed < 0)
      return tell(value, Kind::no_meaning, "below 0 it is drawn from the time; a run is repeatable");
    result_.config.seed = static_cast<std::uint64_t>(seed);
    tell_taken(value, parameter.setting);
  } else if (name == "resample_interval") {
    const std::int64_t interval = whole_number(value);
    if (interval < 1) fail(value, fmt::format(" must be at least 1, got {}", interval));
    if (interval > 1) return tell(value, Kind::no_meaning, "parloc resamples by N_eff, not by counting");
    result_.config.resample.threshold = 1.0;
    tell_taken(value, parameter.setting, "every step");
  } else if (name == "odom_frame_id") {
    if (value.text == "odom") return tell(value, Kind::taken, "as it is without");
    set(value, parameter.setting);
    tell_taken(value, parameter.setting);
  } else if (name.starts_with("z_")) {
    take_share(value, parameter);
  }  // the start: take_start()
}

void Translation::take_range(const Nav2Value& value, const Nav2Parameter& parameter) {
  if (number(value, -1e6, 1e6) < 0.0) return tell(value, Kind::taken, "as the log says");
  set(value, parameter.setting);
  tell_taken(value, parameter.setting, "where the log gives none");
}

void Translation::take_share(const Nav2Value& value, const Nav2Parameter& parameter) {
  const bool is_read = reads_all_shares() || value.name == "z_hit" || value.name == "z_rand";
  if (!is_read) return tell(value, Kind::no_meaning, "only laser_model_type: beam reads it, in nav2 too");
  set(value, parameter.setting);
  lines_[parameter.setting] = value.line;  // told when it is scaled
}

/// nav2 takes shares as they are; here they are shares of all beams.
void Translation::scale_shares() {
  SensorConfig& s = result_.config.sensor;
  const double sum = s.z_hit + s.z_short + s.z_max + s.z_rand;
  const bool is_scaled = sum > 0.0 && std::fabs(sum - 1.0) > 1e-6;
  for (double* share : {&s.z_hit, &s.z_short, &s.z_max, &s.z_rand})
    if (is_scaled && sum > 0.0) *share /= sum;
  for (const Nav2Value& value : nav2_.values) {
    const Nav2Parameter* parameter = nav2_parameter(value.name);
    if (parameter == nullptr || !value.name.starts_with("z_") || line_of(parameter->setting) == 0) continue;
    tell_taken(value, parameter->setting, is_scaled ? "scaled: the shares sum to 1" : "");
  }
}

void Translation::take_start() {
  const Nav2Value* set_pose = find("set_initial_pose");
  const bool starts = set_pose != nullptr && boolean(*set_pose);
  Pose start{0.0, 0.0, 0.0};  // nav2's default
  for (const Nav2Value& value : nav2_.values) {
    double* const target = value.name == "initial_pose.x"     ? &start.x_m
                           : value.name == "initial_pose.y"   ? &start.y_m
                           : value.name == "initial_pose.yaw" ? &start.theta_rad
                                                              : nullptr;
    if (target == nullptr) continue;
    *target = number(value, -kFarthest_m, kFarthest_m);
    if (starts) {
      tell(value, Kind::taken, "the start, where --init is not given");
    } else {
      tell(value, Kind::no_meaning, "set_initial_pose is not true");
    }
  }
  if (set_pose != nullptr)
    tell(*set_pose, Kind::taken,
         starts ? "start at initial_pose, where --init is not given" : "start as --init says");
  start.theta_rad = wrap64(start.theta_rad);
  if (starts) result_.nav2_start = start;
}

std::string names_of(const ConfigFile& file, Nav2Line::Kind kind) {
  constexpr std::size_t most = 8;
  std::vector<std::string> names;
  std::size_t count = 0;
  for (const Nav2Line& line : file.lines)
    if (line.kind == kind && ++count <= most) names.push_back(line.name);
  return fmt::format("{}{}", fmt::join(names, ", "), count > most ? ", ..." : "");
}

std::size_t count_of(const ConfigFile& file, Nav2Line::Kind kind) {
  return static_cast<std::size_t>(std::count_if(file.lines.begin(), file.lines.end(),
                                                [&](const Nav2Line& line) { return line.kind == kind; }));
}

}  // namespace

ConfigFile config_file_from_text(const std::string& text, const std::string& name, const Config& base) {
  ConfigFile file;
  const std::optional<Nav2File> nav2 = nav2_file(text, name);
  if (!nav2) {
    file.config = parloc_config_from_text(text, name, base);
    return file;
  }
  file.config = base;
  file.nav2_node = nav2->node;
  Translation(*nav2, name, file).run();
  return file;
}

ConfigFile read_config_file(const std::string& path, const Config& base) {
  const std::string text = read_yaml_file(path, {"a configuration", kLongestNav2File, ErrorKind::config});
  return config_file_from_text(text, path, base);
}

Config config_from_text(const std::string& text, const std::string& name, const Config& base) {
  return config_file_from_text(text, name, base).config;
}

Config read_config(const std::string& path, const Config& base) {
  return read_config_file(path, base).config;
}

std::vector<std::string> nav2_summary(const ConfigFile& file, const std::string& path) {
  using Kind = Nav2Line::Kind;
  if (file.nav2_node.empty()) return {};
  std::vector<std::string> lines{
      fmt::format("{}: nav2's settings of {}: {} parameters taken; parloc config --config {} lists them",
                  path, printable(file.nav2_node), count_of(file, Kind::taken), path)};
  if (const std::size_t count = count_of(file, Kind::no_meaning); count > 0)
    lines.push_back(
        fmt::format("{}: {} have no meaning here: {}", path, count, names_of(file, Kind::no_meaning)));
  if (const std::size_t count = count_of(file, Kind::unknown); count > 0)
    lines.push_back(
        fmt::format("{}: {} are no parameters of amcl: {}", path, count, names_of(file, Kind::unknown)));
  return lines;
}

std::vector<std::string> nav2_listing(const ConfigFile& file) {
  std::vector<std::string> lines;
  for (const Nav2Line& line : file.lines) {
    const char* what = line.kind == Nav2Line::Kind::taken ? "taken" : "not used";
    lines.push_back(fmt::format("{:<9} {}: {} -> {}", what, line.name, line.value, line.text));
  }
  return lines;
}

}  // namespace parloc
