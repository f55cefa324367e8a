// The table of settings: a name, what it means, what it may be, and the value itself. Each folder lists its
// own settings beside the struct that holds them; reading, printing and checking work on any such list
// (common/settings/*.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace parloc {

/// The values a number may take: low to high, both included unless `above_low`.
template <class Number>
struct Limits {
  Number low;
  Number high;
  bool above_low = false;  ///< low itself is not allowed.
};

/// A named value of an enumeration.
template <class Enum>
struct Choice {
  const char* name;
  Enum value;
};

/// Null for a value that is none of the choices.
template <class Enum>
const char* name_of(Enum value, const std::vector<Choice<Enum>>& choices) {
  for (const Choice<Enum>& choice : choices)
    if (choice.value == value) return choice.name;
  return nullptr;
}

/// A value in a struct that outlives this; one that may be missing is a std::optional there.
template <class Value>
class Slot {
 public:
  Slot(Value& value) : value_(&value) {}                          // NOLINT: converts on purpose
  Slot(std::optional<Value>& value) : may_be_missing_(&value) {}  // NOLINT: converts on purpose

  /// Null if it is missing.
  const Value* get() const {
    if (value_ != nullptr) return value_;
    return may_be_missing_->has_value() ? &**may_be_missing_ : nullptr;
  }
  void set(const Value& value) const {
    if (value_ != nullptr) {
      *value_ = value;
    } else {
      *may_be_missing_ = value;
    }
  }

 private:
  Value* value_ = nullptr;
  std::optional<Value>* may_be_missing_ = nullptr;
};

template <class Number>
struct NumberSetting {
  Slot<Number> slot;
  Limits<Number> limits;
};
using FlagSetting = Slot<bool>;
/// A name of something outside, such as a topic; empty: none is said.
struct TextSetting {
  std::string* text;
};
/// Intervals of a circle, [from, to] each; none is as if it were missing.
struct IntervalsSetting {
  std::function<std::vector<std::pair<double, double>>()> get;
  std::function<void(const std::vector<std::pair<double, double>>& intervals)> set;
  Limits<double> limits;  ///< Of both ends.
  std::size_t most = 0;   ///< Intervals.
};
/// An enumeration, by the names of its values.
struct ChoiceSetting {
  std::vector<std::pair<const char*, std::size_t>> names;  ///< Each with its index.
  std::function<std::optional<int>()> number;  ///< The value as a number; nothing if it is missing.
  std::function<const char*()> name;           ///< Null for a number that none of the names stands for.
  std::function<void(std::size_t k)> choose;   ///< Makes it the value of names[k].
};

/// One setting of a file.
struct Setting {
  std::string group;  ///< Empty at the top level.
  std::string key;
  std::string doc;  ///< One line, with the unit in brackets.
  std::variant<NumberSetting<int>, NumberSetting<std::int64_t>, NumberSetting<std::uint64_t>,
               NumberSetting<double>, FlagSetting, TextSetting, ChoiceSetting, IntervalsSetting>
      value;

  /// "motion.alpha1", or "particles" at the top level.
  std::string name() const { return group.empty() ? key : group + "." + key; }
};

/// A group of settings, in the order in which it is printed.
struct SettingGroup {
  std::string name;
  std::string doc;
};

/// Settings of things that a file names: "lidars:", "  front:", and settings of each below.
struct NamedSettings {
  SettingGroup group;
  const char* a_thing = "";                         ///< "a LiDAR"; for messages.
  std::function<std::vector<std::string>()> names;  ///< Those that there are.
  /// One thing's settings, their group "lidars.front"; it is made if there is none of that name.
  std::function<std::vector<Setting>(const std::string& name)> of;
  std::vector<Setting> example;  ///< Of a thing that stands for all, and outlives this.
  std::string example_name;
};

/// What a name in a group of named settings may be.
inline constexpr const char* kExpectedName = "expected 1 to 40 letters, digits, '_' or '-'";
bool is_setting_name(std::string_view name);

/// What may be wrong with settings, for a reader that knows the line.
struct Violation {
  std::string name;     ///< The setting to blame: "sensor.z_hit".
  std::string message;  ///< One line that names it too.
};

/// All settings of a struct, in printed order.
class Settings {
 public:
  std::vector<SettingGroup> groups;
  std::vector<Setting> all;
  std::optional<NamedSettings> named;

  /// Those that follow belong to it.
  void group(const char* name, const char* doc);
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(const char* key, const char* doc, Number& value, Limits<Number> limits) {
    append(key, doc, NumberSetting<Number>{value, limits});
  }
  template <class Number>
  void add(const char* key, const char* doc, std::optional<Number>& value, Limits<Number> limits) {
    append(key, doc, NumberSetting<Number>{value, limits});
  }
  void add(const char* key, const char* doc, bool& value) { append(key, doc, FlagSetting(value)); }
  void add(const char* key, const char* doc, std::string& value) { append(key, doc, TextSetting{&value}); }
  void add(const char* key, const char* doc, std::optional<bool>& value) {
    append(key, doc, FlagSetting(value));
  }
  /// Interval: {from, to}.
  template <class Interval>
  void add(const char* key, const char* doc, std::vector<Interval>& value, Limits<double> limits,
           std::size_t most) {
    const auto get = [&value] {
      std::vector<std::pair<double, double>> intervals;
      for (const Interval& i : value) intervals.emplace_back(i.from, i.to);
      return intervals;
    };
    const auto set = [&value](const std::vector<std::pair<double, double>>& intervals) {
      value.clear();
      for (const auto& [from, to] : intervals) value.push_back({from, to});
    };
    append(key, doc, IntervalsSetting{get, set, limits, most});
  }
  template <class Enum>
  void add(const char* key, const char* doc, Enum& value, const std::vector<Choice<Enum>>& choices) {
    append(key, doc, by_name(Slot<Enum>(value), choices));
  }
  template <class Enum>
  void add(const char* key, const char* doc, std::optional<Enum>& value,
           const std::vector<Choice<Enum>>& choices) {
    append(key, doc, by_name(Slot<Enum>(value), choices));
  }

 private:
  template <class Enum>
  static ChoiceSetting by_name(Slot<Enum> slot, const std::vector<Choice<Enum>>& choices) {
    ChoiceSetting setting;
    for (const Choice<Enum>& choice : choices) setting.names.emplace_back(choice.name, setting.names.size());
    setting.number = [slot]() -> std::optional<int> {
      const Enum* value = slot.get();
      return value != nullptr ? std::optional(static_cast<int>(*value)) : std::nullopt;
    };
    setting.name = [slot, choices]() -> const char* {
      return slot.get() != nullptr ? name_of(*slot.get(), choices) : nullptr;
    };
    setting.choose = [slot, choices](std::size_t k) { slot.set(choices[k].value); };
    return setting;
  }
  template <class Value>
  void append(const char* key, const char* doc, Value value) {
    all.push_back({current_, key, doc, std::move(value)});
  }

  std::string current_;
};

/// "1 to 4096", "above 0 and at most 1", "true or false", "skip, dda or fixed_step".
std::string allowed_text(const Setting& setting);
/// The value as a file has it; nothing if it is missing.
std::optional<std::string> value_text(const Setting& setting);
/// "motion.alpha1 must be 0 to 100, got -1"; empty if the value is allowed or missing.
std::string limits_message(const Setting& setting);
/// The first setting outside its limits. A struct's own rules come after that.
std::optional<Violation> first_beyond_limits(const Settings& settings);
/// Throws Error{config} if there is one.
void require_none(const std::optional<Violation>& violation);

/// Every key with a comment that explains it.
std::string settings_to_yaml(const Settings& settings);
/// The first setting by name in which they differ, and how: "seed is 1 there and 2 here"; empty if there is
/// none. `ignored` are names that are not compared.
std::string settings_difference(const Settings& there, const Settings& here,
                                const std::vector<std::string>& ignored);

}  // namespace parloc
