#include "common/settings/setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "common/error.h"
#include "common/file/yaml_section.h"

namespace parloc {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// False for NaN too.
template <class Number>
bool within(Number value, const Limits<Number>& limits) {
  return value >= limits.low && value <= limits.high && !(limits.above_low && value == limits.low);
}

}  // namespace

void Settings::group(const char* name, const char* doc) {
  groups.push_back({name, doc});
  current_ = name;
}

namespace {
/// Names of topics and frames have no more than that.
bool is_plain_text(std::string_view text) {
  return text.size() <= 256 && std::all_of(text.begin(), text.end(), [](char c) {
           return c >= ' ' && c <= '~' && c != '"' && c != '\\';
         });
}
}  // namespace

bool is_setting_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), allowed);
}

std::string allowed_text(const Setting& setting) {
  return std::visit(Overloaded{[](const auto& number) {
                                 return limits_text(number.limits.low, number.limits.high,
                                                    number.limits.above_low);
                               },
                               [](const FlagSetting&) { return std::string("true or false"); },
                               [](const TextSetting&) { return std::string("a text"); },
                               [](const ChoiceSetting& choice) { return choices_text(choice.names); },
                               [](const IntervalsSetting& list) {
                                 return fmt::format("up to {} of [from, to], each {}", list.most,
                                                    limits_text(list.limits.low, list.limits.high, false));
                               }},
                    setting.value);
}

std::optional<std::string> value_text(const Setting& setting) {
  using Text = std::optional<std::string>;
  return std::visit(
      Overloaded{[](const auto& number) {  // fmt's {} is the shortest text that reads back as the same number
                   const auto* value = number.slot.get();
                   return value != nullptr ? Text(fmt::format("{}", *value)) : Text();
                 },
                 [](const FlagSetting& flag) {
                   return flag.get() != nullptr ? Text(*flag.get() ? "true" : "false") : Text();
                 },
                 [](const TextSetting& text) { return Text(fmt::format("\"{}\"", *text.text)); },
                 [](const ChoiceSetting& choice) {
                   const char* name = choice.name();
                   return choice.number() ? Text(name != nullptr ? name : "?") : Text();
                 },
                 [](const IntervalsSetting& list) {
                   std::string text;
                   for (const auto& [from, to] : list.get())
                     text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", from, to);
                   return text.empty() ? Text() : Text("[" + text + "]");
                 }},
      setting.value);
}

std::string limits_message(const Setting& setting) {
  const auto must = [&](const std::string& got) {
    return fmt::format("{} must be {}, got {}", setting.name(), allowed_text(setting), got);
  };
  return std::visit(
      Overloaded{[&](const auto& number) {
                   const auto* value = number.slot.get();
                   const bool allowed = value == nullptr || within(*value, number.limits);
                   return allowed ? std::string() : must(fmt::format("{}", *value));
                 },
                 [](const FlagSetting&) { return std::string(); },
                 [&](const TextSetting& text) {
                   return is_plain_text(*text.text)
                              ? std::string()
                              : fmt::format(
                                    "{} must be at most 256 printable characters without quotes, got '{}'",
                                    setting.name(), printable(*text.text));
                 },
                 [&](const ChoiceSetting& choice) {
                   const std::optional<int> number = choice.number();
                   const bool allowed = !number || choice.name() != nullptr;
                   return allowed ? std::string() : must(fmt::format("the number {}", *number));
                 },
                 [&](const IntervalsSetting& list) {
                   const auto intervals = list.get();
                   if (intervals.size() > list.most) return must(fmt::format("{} of them", intervals.size()));
                   for (const auto& [from, to] : intervals)
                     if (!within(from, list.limits) || !within(to, list.limits))
                       return must(fmt::format("[{}, {}]", from, to));
                   return std::string();
                 }},
      setting.value);
}

std::optional<Violation> first_beyond_limits(const Settings& settings) {
  for (const Setting& setting : settings.all)
    if (const std::string message = limits_message(setting); !message.empty())
      return Violation{setting.name(), message};
  return std::nullopt;
}

void require_none(const std::optional<Violation>& violation) {
  if (violation) throw Error(ErrorKind::config, violation->message);
}

namespace {

/// "  key: value   # what it means (limits)"
std::string line_of(const Setting& setting, const std::string& indent, const std::string& value) {
  const std::string entry = fmt::format("{}{}: {}", indent, setting.key, value);
  return fmt::format("{:<36}  # {} ({})\n", entry, setting.doc, allowed_text(setting));
}

std::string lines_of(const std::vector<Setting>& settings, const std::string& indent) {
  std::string text;
  for (const Setting& setting : settings)
    if (const auto value = value_text(setting)) text += line_of(setting, indent, *value);
  return text;
}

/// Each thing's settings; where there is none, one that is commented out and says what it may hold.
std::string named_to_yaml(const NamedSettings& named) {
  const SettingGroup& group = named.group;
  if (named.names().empty())
    return fmt::format("\n# {}\n# {}:\n#   {}:\n{}", group.doc, group.name, named.example_name,
                       lines_of(named.example, "#     "));
  std::string text;
  for (const std::string& name : named.names())
    text += fmt::format("  {}:\n{}", name, lines_of(named.of(name), "    "));
  return fmt::format("\n# {}\n{}:\n{}", group.doc, group.name, text);
}

std::map<std::string, std::string> texts_of(const Settings& settings,
                                            const std::vector<std::string>& ignored) {
  std::map<std::string, std::string> texts;
  const auto take = [&](const std::vector<Setting>& some) {
    for (const Setting& setting : some)
      if (const auto value = value_text(setting)) texts[setting.name()] = *value;
  };
  take(settings.all);
  if (settings.named)
    for (const std::string& name : settings.named->names()) take(settings.named->of(name));
  for (const std::string& name : ignored) texts.erase(name);
  return texts;
}

}  // namespace

std::string settings_to_yaml(const Settings& settings) {
  std::string text, group;
  for (const Setting& setting : settings.all) {
    if (setting.group != group) {
      group = setting.group;
      for (const SettingGroup& known : settings.groups)
        if (known.name == group) text += fmt::format("\n# {}\n{}:\n", known.doc, group);
    }
    if (const auto value = value_text(setting)) text += line_of(setting, group.empty() ? "" : "  ", *value);
  }
  return settings.named ? text + named_to_yaml(*settings.named) : text;
}

std::string settings_difference(const Settings& there, const Settings& here,
                                const std::vector<std::string>& ignored) {
  std::map<std::string, std::string> old_text = texts_of(there, ignored), new_text = texts_of(here, ignored);
  for (const auto& leaf : new_text) old_text.try_emplace(leaf.first, "not set");
  for (const auto& [key, value] : old_text) {
    const std::string& now = new_text.try_emplace(key, "not set").first->second;
    if (value != now) return fmt::format("{} is {} there and {} here", key, value, now);
  }
  return "";
}

}  // namespace parloc
