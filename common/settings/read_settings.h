// From the text of a file to the values of settings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/settings/settings_entries.h"

namespace parloc {

/// The text of a file of settings. Throws Error{config} if it cannot be read; a text longer than any that is
/// read is cut.
std::string read_settings_file(const std::string& path);

/// A text, and what is to be made of it. All functions throw Error{config} with file:line for a wrong type or
/// a value out of its range (naming the range).
class SettingsText {
 public:
  /// Throws as settings_entries().
  SettingsText(const std::string& text, std::string file, const Settings& known);

  /// Null if the text does not have it.
  const SettingsEntry* find(const std::string& name) const;
  /// Sets the setting of that name only.
  void set(Settings& to, const std::string& name) const;
  void set_all(Settings& to) const;
  /// Throws at the line of the setting to blame, if there is one.
  void require_none(const std::optional<Violation>& violation) const;
  [[noreturn]] void fail(const SettingsEntry* entry, const std::string& message) const;

 private:
  std::string file_;
  std::vector<SettingsEntry> entries_;
};

}  // namespace parloc
