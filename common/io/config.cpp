// Reads a configuration: YAML text -> entries (config_entries.h) -> the table of settings.
#include "common/io/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#include "common/error.h"
#include "common/io/config_entries.h"
#include "common/io/config_rules.h"
#include "common/io/config_text.h"

namespace parloc {
namespace {

using config_text::full_name;
using config_text::printable;

/// Sets the one field that `entry` names.
class FieldSetter {
 public:
  FieldSetter(const std::string& file, const ConfigEntry& entry) : file_(file), entry_(entry) {}

  template <class Number>
  void operator()(const Field& field, Number& target, const Limits<Number>& limits) {
    if (!matches(field)) return;
    constexpr const char* wanted = std::is_integral_v<Number> ? "a whole number" : "a number";
    const Number value = parse<Number>(field, wanted, limits);
    if (!config_text::within(value, limits)) fail(config_text::limits_message(field, value, limits));
    target = value;
  }
  template <class Value, class Allowed>
  void operator()(const Field& field, std::optional<Value>& target, const Allowed& allowed) {
    if (!matches(field)) return;
    Value value{};
    (*this)(field, value, allowed);
    target = value;
  }
  void operator()(const Field& field, bool& target) {
    if (!matches(field)) return;
    const bool yes = !entry_.quoted && entry_.value == "true";
    if (!yes && (entry_.quoted || entry_.value != "false")) fail_type(field, "true or false");
    target = yes;
  }
  template <class Enum, std::size_t n>
  void operator()(const Field& field, Enum& target, const std::array<Choice<Enum>, n>& choices) {
    if (!matches(field)) return;
    for (const auto& choice : choices) {
      if (entry_.value == choice.name) {
        target = choice.value;
        return;
      }
    }
    fail_type(field, config_text::choices_text(choices));
  }

 private:
  bool matches(const Field& field) const { return entry_.group == field.group && entry_.key == field.key; }
  /// Locale-independent; the whole text must be the number.
  template <class Number>
  Number parse(const Field& field, const char* wanted, const Limits<Number>& limits) const {
    std::string_view text = entry_.value;
    if (entry_.quoted || text.empty()) fail_type(field, wanted);
    if (text.front() == '+' && text.size() > 1 && text[1] != '-')
      text.remove_prefix(1);  // from_chars knows no '+'
    Number value{};
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = end == text.data() + text.size();
    const bool negative_unsigned = std::is_unsigned_v<Number> && is_negative_integer(text);
    if (negative_unsigned || (whole && status == std::errc::result_out_of_range)) {
      fail(fmt::format("{} must be {}, got {}", full_name(field), config_text::limits_text(limits),
                       printable(entry_.value)));
    }
    if (!whole || status != std::errc()) fail_type(field, wanted);
    if constexpr (std::is_floating_point_v<Number>) {
      if (!std::isfinite(value)) fail_type(field, "a finite number");
    }
    return value;
  }
  static bool is_negative_integer(std::string_view text) {
    return text.size() > 1 && text.front() == '-' && std::all_of(text.begin() + 1, text.end(), [](char c) {
             return std::isdigit(static_cast<unsigned char>(c)) != 0;
           });
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw config_text::error(file_, entry_.line, message);
  }
  [[noreturn]] void fail_type(const Field& field, const std::string& wanted) const {
    const std::string got = entry_.empty    ? "nothing"
                            : entry_.quoted ? fmt::format("the text \"{}\"", printable(entry_.value))
                                            : fmt::format("'{}'", printable(entry_.value));
    fail(fmt::format("{}: expected {}, got {}", full_name(field), wanted, got));
  }

  const std::string& file_;
  const ConfigEntry& entry_;
};

const ConfigEntry* find_entry(const std::vector<ConfigEntry>& entries, std::string_view name) {
  for (const ConfigEntry& entry : entries) {
    if (full_name(entry.group, entry.key) == name) return &entry;
  }
  return nullptr;
}

/// The alphas mean different things in the two forms, so a file that sets one must say which form it means.
void require_form(const std::vector<ConfigEntry>& entries, const std::string& name) {
  if (find_entry(entries, "motion.form") != nullptr) return;
  for (const char* alpha : {"motion.alpha1", "motion.alpha2", "motion.alpha3", "motion.alpha4"}) {
    if (const ConfigEntry* entry = find_entry(entries, alpha)) {
      throw config_text::error(
          name, entry->line,
          fmt::format("{} needs motion.form beside it: seed (sigma linear in the motion) or thrun "
                      "(variance quadratic, as AMCL)",
                      alpha));
    }
  }
}

/// The LiDAR of a group "lidars.front"; made if it is the first time. Null for another group.
LidarConfig* lidar_of(const std::string& group, std::vector<LidarConfig>& lidars) {
  const std::string prefix = std::string(kLidars.name) + ".";
  if (group.rfind(prefix, 0) != 0) return nullptr;
  const std::string name = group.substr(prefix.size());
  for (LidarConfig& lidar : lidars)
    if (lidar.name == name) return &lidar;
  lidars.emplace_back().name = name;
  return &lidars.back();
}

}  // namespace

FilterConfig config_from_text(const std::string& text, const std::string& name, const FilterConfig& base) {
  const std::vector<ConfigEntry> entries = config_entries(text, name);
  FilterConfig config = base;
  if (const ConfigEntry* model = find_entry(entries, "sensor.model")) {  // first: it decides other defaults
    FieldSetter setter(name, *model);
    visit_fields(config, setter);
    config.sensor = default_sensor(config.sensor.model);
  }
  for (const ConfigEntry& entry : entries) {
    FieldSetter setter(name, entry);
    if (LidarConfig* lidar = lidar_of(entry.group, config.lidars)) {
      visit_lidar_fields(*lidar, entry.group.c_str(), setter);
    } else {
      visit_fields(config, setter);
    }
  }
  require_form(entries, name);
  if (const auto violation = first_violation(config)) {
    const ConfigEntry* entry = find_entry(entries, violation->name);
    throw config_text::error(name, entry != nullptr ? entry->line : 0, violation->message);
  }
  return config;
}

FilterConfig read_config(const std::string& path, const FilterConfig& base) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw config_text::error(path, 0, fmt::format("cannot be opened: {}", std::strerror(errno)));
  std::string text(kLongestConfig + 1, '\0');  // one byte more than allowed tells a file that is too long
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw config_text::error(path, 0, "cannot be read (is it a folder?)");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return config_from_text(text, path, base);
}

}  // namespace parloc
