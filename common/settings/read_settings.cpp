#include "common/settings/read_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "common/error.h"

namespace parloc {
namespace {

bool is_negative_integer(std::string_view text) {
  return text.size() > 1 && text.front() == '-' && std::all_of(text.begin() + 1, text.end(), [](char c) {
           return std::isdigit(static_cast<unsigned char>(c)) != 0;
         });
}

/// Sets one setting to what one entry says.
class EntryReader {
 public:
  EntryReader(const SettingsText& text, const SettingsEntry& entry, const Setting& setting)
      : text_(text), entry_(entry), setting_(setting) {}

  template <class Number>
  void operator()(const NumberSetting<Number>& number) const {
    number.slot.set(parse<Number>());
    if (const std::string message = limits_message(setting_); !message.empty()) text_.fail(&entry_, message);
  }
  void operator()(const FlagSetting& flag) const {
    const bool yes = !entry_.quoted && entry_.value == "true";
    if (!yes && (entry_.quoted || entry_.value != "false")) fail_type(allowed_text(setting_));
    flag.set(yes);
  }
  void operator()(const ChoiceSetting& choice) const {
    const auto found = std::find(choice.names.begin(), choice.names.end(), entry_.value);
    if (found == choice.names.end()) fail_type(allowed_text(setting_));
    choice.choose(static_cast<std::size_t>(found - choice.names.begin()));
  }

 private:
  /// Locale-independent; the whole text must be the number.
  template <class Number>
  Number parse() const {
    constexpr const char* wanted = std::is_integral_v<Number> ? "a whole number" : "a number";
    std::string_view text = entry_.value;
    if (entry_.quoted || text.empty()) fail_type(wanted);
    if (text.front() == '+' && text.size() > 1 && text[1] != '-')
      text.remove_prefix(1);  // from_chars knows no '+'
    Number value{};
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = end == text.data() + text.size();
    const bool negative_unsigned = std::is_unsigned_v<Number> && is_negative_integer(text);
    if (negative_unsigned || (whole && status == std::errc::result_out_of_range))
      text_.fail(&entry_, fmt::format("{} must be {}, got {}", setting_.name(), allowed_text(setting_),
                                      printable(entry_.value)));
    if (!whole || status != std::errc()) fail_type(wanted);
    if constexpr (std::is_floating_point_v<Number>)
      if (!std::isfinite(value)) fail_type("a finite number");
    return value;
  }
  [[noreturn]] void fail_type(const std::string& wanted) const {
    const std::string got = entry_.empty    ? "nothing"
                            : entry_.quoted ? fmt::format("the text \"{}\"", printable(entry_.value))
                                            : fmt::format("'{}'", printable(entry_.value));
    text_.fail(&entry_, fmt::format("{}: expected {}, got {}", setting_.name(), wanted, got));
  }

  const SettingsText& text_;
  const SettingsEntry& entry_;
  const Setting& setting_;
};

/// The thing's name in a group "lidars.front"; empty for another group.
std::string named_thing(const Settings& settings, const std::string& group) {
  if (!settings.named) return "";
  const std::string prefix = settings.named->group.name + ".";
  return group.rfind(prefix, 0) == 0 ? group.substr(prefix.size()) : "";
}

}  // namespace

SettingsText::SettingsText(const std::string& text, std::string file, const Settings& known)
    : file_(std::move(file)), entries_(settings_entries(text, file_, known)) {}

const SettingsEntry* SettingsText::find(const std::string& name) const {
  const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const SettingsEntry& e) { return e.name() == name; });
  return entry != entries_.end() ? &*entry : nullptr;
}

void SettingsText::fail(const SettingsEntry* entry, const std::string& message) const {
  throw Error(ErrorKind::config, entry != nullptr ? fmt::format("{}:{}: {}", file_, entry->line, message)
                                                  : fmt::format("{}: {}", file_, message));
}

void SettingsText::require_none(const std::optional<Violation>& violation) const {
  if (violation) fail(find(violation->name), violation->message);
}

void SettingsText::set(Settings& to, const std::string& name) const {
  for (const SettingsEntry& entry : entries_) {
    if (entry.name() != name) continue;
    const std::string thing = named_thing(to, entry.group);
    for (const Setting& setting : thing.empty() ? to.all : to.named->of(thing))
      if (setting.name() == name) std::visit(EntryReader(*this, entry, setting), setting.value);
  }
}

void SettingsText::set_all(Settings& to) const {
  for (const SettingsEntry& entry : entries_) set(to, entry.name());
}

std::string read_settings_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(ErrorKind::config, fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
  std::string text(kLongestSettings + 1, '\0');  // one byte more than allowed tells a file that is too long
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw Error(ErrorKind::config, path + ": cannot be read (is it a folder?)");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace parloc
