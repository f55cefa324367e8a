#include "common/settings/read_settings.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/error.h"

namespace parloc {
namespace {

/// Sets one setting, if its group in the file has its key.
class Reader {
 public:
  Reader(const YamlSection& section, const Setting& setting) : section_(section), setting_(setting) {}

  template <class Number>
  void operator()(const NumberSetting<Number>& number) const {
    Number value{};
    section_.number(setting_.key, value, number.limits.low, number.limits.high, number.limits.above_low);
    if (section_.has(setting_.key)) number.slot.set(value);
  }
  void operator()(const FlagSetting& flag) const {
    bool value = false;
    section_.boolean(setting_.key, value);
    if (section_.has(setting_.key)) flag.set(value);
  }
  void operator()(const TextSetting& text) const { section_.text(setting_.key, *text.text, true); }
  void operator()(const ChoiceSetting& choice) const {
    std::size_t chosen = 0;
    section_.choice(setting_.key, chosen, choice.names);
    if (section_.has(setting_.key)) choice.choose(chosen);
  }

  /// [[from, to], ...], or one [from, to].
  void operator()(const IntervalsSetting& list) const {
    const std::string expected = fmt::format("a list of up to {} intervals [from, to]", list.most);
    const std::vector<YamlNode>& items = section_.list(setting_.key, expected, 0);
    if (!section_.has(setting_.key)) return;
    const auto end = [&](const YamlNode& node) {
      return section_.number_in(node, setting_.name(), list.limits.low, list.limits.high);
    };
    std::vector<std::pair<double, double>> intervals;
    if (items.size() == 2 && items[0].kind != YamlKind::list && items[1].kind != YamlKind::list) {
      intervals.emplace_back(end(items[0]), end(items[1]));
    } else {
      if (items.size() > list.most) throw wrong(expected, fmt::format("a list of {}", items.size()));
      for (const YamlNode& item : items) {
        if (item.kind != YamlKind::list || item.items.size() != 2)
          throw wrong(expected, "one that is not [from, to]");
        intervals.emplace_back(end(item.items[0]), end(item.items[1]));
      }
    }
    list.set(intervals);
  }

 private:
  Error wrong(const std::string& expected, const std::string& got) const {
    return section_.error_at(section_.line(setting_.key),
                             fmt::format("{}: expected {}, got {}", setting_.name(), expected, got));
  }

  const YamlSection& section_;
  const Setting& setting_;
};

void read(const YamlSection& section, const Setting& setting) {
  std::visit(Reader(section, setting), setting.value);
}

void read_named(const YamlSection& things, const NamedSettings& named) {
  for (const std::string& name : things.keys()) {
    if (!is_setting_name(name))
      throw things.error_at(things.line(name), fmt::format("{}: '{}' is no name of {}: {}", named.group.name,
                                                           printable(name), named.a_thing, kExpectedName));
    const YamlSection section = things.section(name);
    if (section.keys().empty()) continue;  // it says nothing
    for (const Setting& setting : named.of(name)) read(section, setting);
  }
}

}  // namespace

void read_settings(const YamlSection& top, const Settings& settings) {
  for (const Setting& setting : settings.all)
    if (setting.group.empty()) read(top, setting);
  for (const SettingGroup& group : settings.groups) {
    const YamlSection section = top.section(group.name);
    for (const Setting& setting : settings.all)
      if (setting.group == group.name) read(section, setting);
  }
  if (settings.named) read_named(top.section(settings.named->group.name), *settings.named);
}

void read_setting(const YamlSection& top, const Settings& settings, const std::string& name) {
  for (const Setting& setting : settings.all)
    if (setting.name() == name) read(setting.group.empty() ? top : top.section(setting.group), setting);
}

void require_none(const YamlSection& top, const std::optional<Violation>& violation) {
  if (violation) throw top.error_at(top.line(violation->name), violation->message);
}

}  // namespace parloc
