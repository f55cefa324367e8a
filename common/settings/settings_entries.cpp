// YAML events -> entries. Events rather than a node tree: every entry has its line, nothing is nested deeper
// than a group, and anchors (with them: alias bombs) are refused before they can mean anything.
#include "common/settings/settings_entries.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/file/nearest_name.h"

namespace parloc {
namespace {

Error error(const std::string& file, std::size_t line, const std::string& message) {
  const std::string where = line > 0 ? fmt::format("{}:{}", file, line) : file;
  return Error(ErrorKind::config, where + ": " + message);
}

std::string full_name(const std::string& group, const std::string& key) {
  return group.empty() ? key : group + "." + key;
}

/// The names that a file may have.
class KnownNames {
 public:
  explicit KnownNames(const Settings& settings) : settings_(settings) {}

  std::string named_group() const { return settings_.named ? settings_.named->group.name : ""; }
  bool is_group(const std::string& name) const {
    return (settings_.named && name == named_group()) ||
           std::any_of(settings_.groups.begin(), settings_.groups.end(),
                       [&](const SettingGroup& g) { return g.name == name; });
  }
  bool is_setting(const std::string& group, const std::string& key) const {
    const auto& settings = is_thing(group) ? settings_.named->example : settings_.all;
    return std::any_of(settings.begin(), settings.end(), [&](const Setting& s) {
      return s.key == key && (is_thing(group) || s.group == group);
    });
  }
  /// With the valid name nearest to the misspelt one; the same group wins a tie.
  std::string unknown_key_message(const std::string& group, const std::string& key) const {
    const std::string written = printable(full_name(group, key));
    constexpr std::size_t longest_sensible = 100;  // bounds the work that a hostile key makes
    if (key.size() > longest_sensible) return fmt::format("unknown key '{}'", written);
    std::size_t best = static_cast<std::size_t>(-1);
    std::string nearest;
    const auto consider = [&](const std::string& known_group, const std::string& known_key) {
      // Doubled, so that another group costs half a letter: it breaks ties, no more.
      const std::size_t distance = 2 * edit_distance(key, known_key) + (group == known_group ? 0 : 1);
      if (distance >= best) return;
      best = distance;
      nearest = full_name(known_group, known_key);
    };
    if (is_thing(group)) {
      for (const Setting& s : settings_.named->example) consider(group, s.key);
    } else {
      for (const Setting& s : settings_.all) consider(s.group, s.key);
    }
    if (group.empty()) {
      for (const SettingGroup& known : settings_.groups) consider("", known.name);
      if (settings_.named) consider("", named_group());
    }
    return fmt::format("unknown key '{}'; the nearest valid key is '{}'", written, nearest);
  }

 private:
  /// Whether it is "lidars.front", whatever the name.
  bool is_thing(const std::string& group) const {
    return settings_.named && group.rfind(named_group() + ".", 0) == 0;
  }

  const Settings& settings_;
};

/// Collects the entries of one document; throws Error{config} at the first thing that a configuration cannot
/// hold.
class EntryCollector : public YAML::EventHandler {
 public:
  EntryCollector(const std::string& file, const Settings& known) : file_(file), known_(known) {}
  std::vector<SettingsEntry> entries;

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(line_of(mark), "expected one document, found a second one ('---')");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_extras(mark, "", anchor);
    if (level_ == Level::document) return;  // a file of comments: all defaults
    if (!key_) fail(line_of(mark), "expected a key, found none");
    take_value("", false, true);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(line_of(mark), "aliases ('*name') are not allowed");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_extras(mark, tag, anchor);
    if (level_ == Level::document) {
      fail(line_of(mark), fmt::format("expected lines of 'key: value', got '{}'", printable(value)));
    }
    if (key_) {
      take_value(value, tag == "!", false);
    } else {
      key_ = value;
      key_line_ = line_of(mark);
    }
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    if (!key_) fail(line_of(mark), "expected lines of 'key: value', got a list");
    require_known_key();
    if (level_ == Level::things || *key_ == known_.named_group()) {
      fail(line_of(mark),
           fmt::format("expected indented lines below '{}', got a list", full_name(group_, *key_)));
    }
    fail(line_of(mark), fmt::format("expected a single value for '{}', got a list", *key_));
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    refuse_extras(mark, tag, anchor);
    if (level_ == Level::document) {
      level_ = Level::top;
      return;
    }
    if (!key_) fail(line_of(mark), "expected a key, got a group");
    require_known_key();
    const bool opens = level_ == Level::things || (level_ == Level::top && known_.is_group(*key_));
    if (!opens) {
      fail(line_of(mark),
           fmt::format("expected a single value for '{}', got a group", full_name(group_, *key_)));
    }
    note_group();
    level_ = level_ == Level::things         ? Level::thing
             : *key_ == known_.named_group() ? Level::things
                                             : Level::group;
    group_ = full_name(group_, *key_);
    key_.reset();
  }
  void OnMapEnd() override {
    group_ = level_ == Level::thing ? known_.named_group() : "";
    level_ = level_ == Level::thing                              ? Level::things
             : level_ == Level::group || level_ == Level::things ? Level::top
                                                                 : Level::document;
  }

 private:
  enum class Level { document, top, group, things, thing };

  static std::size_t line_of(const YAML::Mark& mark) {
    return mark.line < 0 ? 0 : static_cast<std::size_t>(mark.line) + 1;
  }
  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    throw error(file_, line, message);
  }
  void refuse_extras(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) const {
    if (anchor != 0) fail(line_of(mark), "anchors ('&name') are not allowed");
    if (!tag.empty() && tag != "?" && tag != "!") {  // "?" is a plain scalar, "!" a quoted one
      fail(line_of(mark), fmt::format("type tags are not allowed, got '{}'", printable(tag)));
    }
  }
  void require_known_key() const {
    if (level_ == Level::things) {
      if (is_setting_name(*key_)) return;
      fail(key_line_, fmt::format("lidars: '{}' is no name of a LiDAR: {}", printable(*key_), kExpectedName));
    }
    const bool known = known_.is_setting(group_, *key_) || (level_ == Level::top && known_.is_group(*key_));
    if (!known) fail(key_line_, known_.unknown_key_message(group_, *key_));
  }
  void note_group() {
    const std::string name = full_name(group_, *key_);
    if (std::find(seen_groups_.begin(), seen_groups_.end(), name) != seen_groups_.end()) {
      fail(key_line_, fmt::format("duplicate group '{}'", name));
    }
    seen_groups_.push_back(name);
  }
  void take_value(const std::string& value, bool quoted, bool empty) {
    require_known_key();
    if (level_ == Level::things || (level_ == Level::top && known_.is_group(*key_))) {
      if (!empty) {
        fail(key_line_,
             fmt::format("'{}' is a group: expected indented 'key: value' lines below it, got '{}'",
                         full_name(group_, *key_), printable(value)));
      }
      note_group();  // all of its keys are commented out
    } else {
      for (const SettingsEntry& earlier : entries) {
        if (earlier.group != group_ || earlier.key != *key_) continue;
        fail(key_line_,
             fmt::format("duplicate key '{}', first on line {}", full_name(group_, *key_), earlier.line));
      }
      entries.push_back({group_, *key_, value, key_line_, quoted, empty});
    }
    key_.reset();
  }

  const std::string& file_;
  const KnownNames known_;
  std::vector<std::string> seen_groups_;
  std::string group_;
  std::optional<std::string> key_;  ///< Read, its value not yet.
  std::size_t key_line_ = 0;
  Level level_ = Level::document;
  int documents_ = 0;
};

void refuse_binary(const std::string& text, const std::string& file) {
  if (text.size() > kLongestSettings) {
    throw error(file, 0, fmt::format("expected a configuration of at most {} KiB", kLongestSettings / 1024));
  }
  std::size_t line = 1;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool control = byte < 0x20 && c != '\t' && c != '\n' && c != '\r';
    if (control || byte == 0x7f) {
      throw error(file, line, fmt::format("expected text, found the byte 0x{:02x}", byte));
    }
    if (c == '\n') ++line;
  }
}

}  // namespace

std::vector<SettingsEntry> settings_entries(const std::string& text, const std::string& file,
                                            const Settings& known) {
  refuse_binary(text, file);
  EntryCollector collector(file, known);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(collector)) {
    }
  } catch (const YAML::Exception& e) {
    const std::size_t line = e.mark.line < 0 ? 0 : static_cast<std::size_t>(e.mark.line) + 1;
    throw error(file, line, "not valid YAML: " + printable(e.msg));
  }
  return std::move(collector.entries);
}

}  // namespace parloc
