// The groups of a small YAML file, read strictly: whatever nobody asked for is an error with its nearest
// valid name.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/yaml_reader.h"

namespace parloc {

/// "1 to 4096", or "above 0 and at most 1".
template <class Number>
std::string limits_text(Number low, Number high, bool above_low) {
  return above_low ? fmt::format("above {} and at most {}", low, high) : fmt::format("{} to {}", low, high);
}

/// "seed or thrun"; "skip, dda or fixed_step".
template <class Choices>
std::string choices_text(const Choices& choices) {
  std::string text;
  std::size_t left = std::size(choices);
  for (const auto& [name, value] : choices) {
    text += name;
    if (--left > 0) text += left > 1 ? ", " : " or ";
  }
  return text;
}

/// Reads an int, a 64-bit integer or a double within its limits, which are included but for an excluded
/// `low`. Returns what is wrong with the scalar, to stand behind its name: ": expected a number, got 'x'" or
/// " must be 0 to 1, got 2"; empty if nothing is. A quoted scalar is no number, NaN is outside any limits.
template <class Number>
std::string read_number(YamlKind kind, const std::string& text, Number& target, Number low, Number high,
                        bool above_low = false);

/// What stands behind a key.
struct YamlScalar {
  bool is_one = false;    ///< Not a list, a group or nothing.
  std::string text;       ///< Empty unless it is one.
  std::string described;  ///< For messages: "'5cm'" or "a list".
  std::size_t line = 0;   ///< Of a wrong value, for messages.
};

/// One group. Ask for every key that it and the groups inside may have, then call finish() of the outermost.
/// Absent keys leave their target alone; a group with nothing in it is empty. All functions throw
/// Error{rules.error} with file:line for a wrong type or a value outside its limits.
class YamlSection {
 public:
  /// The outermost group of a text.
  YamlSection(const std::string& text, const std::string& file, const YamlRules& rules);

  /// The group's place: "" for the outermost, "lidars[1]".
  const std::string& name() const { return name_; }
  bool has(const std::string& key) const { return find(key) != nullptr; }
  std::vector<std::string> keys() const;
  /// A value that the caller reads itself; none if the key is absent.
  YamlScalar scalar(const std::string& key) const;
  /// The line of a key, 0 if the file has none. "sensor.z_hit" is looked up inside of `sensor`.
  std::size_t line(const std::string& path) const;

  /// finish() throws if the key is absent: after unknown keys, one of which it may be misspelt.
  void require(const std::string& key) const;
  template <class Number>
  void number(const std::string& key, Number& target, std::type_identity_t<Number> low,
              std::type_identity_t<Number> high, bool above_low = false) const {
    if (const YamlNode* node = find(key))
      expect_number(*node, full_name(key), read_number(node->kind, node->text, target, low, high, above_low));
  }
  void text(const std::string& key, std::string& target, bool may_be_empty = false) const;
  /// One of the names; the target becomes its value.
  template <class Value, class Choices = std::initializer_list<std::pair<const char*, Value>>>
  void choice(const std::string& key, Value& target, const Choices& choices) const {
    const YamlNode* node = find(key);
    if (node == nullptr) return;
    const bool scalar =
        node->kind == YamlKind::plain || (node->kind == YamlKind::quoted && !std::is_same_v<Value, bool>);
    for (const auto& [name, value] : choices) {
      if (!scalar || node->text != name) continue;
      target = value;
      return;
    }
    throw mismatch(*node, choices_text(choices));
  }
  void boolean(const std::string& key, bool& target) const {
    choice(key, target, {{"true", true}, {"false", false}});
  }
  /// A list of `least` to `most` values; `expected` describes it in messages. Empty if the key is absent.
  const std::vector<YamlNode>& list(const std::string& key, const std::string& expected, std::size_t least,
                                    std::size_t most = static_cast<std::size_t>(-1)) const;
  /// A list of exactly `count` numbers within the limits.
  void numbers(const std::string& key, double* target, std::size_t count, double low, double high,
               const std::string& expected) const;
  YamlSection section(const std::string& key) const;
  /// A list of groups, named key[0], key[1], ...; empty if the key is absent.
  std::vector<YamlSection> sections(const std::string& key) const;

  /// Throws if the file has a key that was never asked for, naming the nearest one that was, or lacks one
  /// that is required.
  void finish() const;

  /// A number that stands in a list(); `what` names it.
  double number_in(const YamlNode& node, const std::string& what, double low, double high) const;
  /// An error at the key's line, or else at the group's: "file:line: section.key message".
  Error error(const std::string& key, const std::string& message) const;
  Error error_at(std::size_t line, const std::string& message) const;

 private:
  struct Document;
  YamlSection(std::shared_ptr<Document> document, YamlNode* node, std::string name);

  void expect_group();
  /// Null if the key is absent.
  YamlNode* find(const std::string& key) const;
  std::string full_name(const std::string& key) const;
  void expect_number(const YamlNode& node, const std::string& what, const std::string& wrong) const;
  Error mismatch(const YamlNode& node, const std::string& expected) const;

  std::shared_ptr<Document> document_;
  YamlNode* node_;  // null: the group was left out, or has nothing in it
  std::string name_;
};

}  // namespace parloc
